"""One cheap call of every public function; ``CALLS[name](k)`` for a few different k."""

import control
import numpy as np
import scipy.stats
import sympy as sp

import symfric as sf

X, U = sp.symbols("x u", real=True)
MOTION = sf.motions.sine_burst(1.0, 1.0, cycles=4)
PERIODS = np.array([0.2, 0.5, 1.0])
BELT = {"v_b": (0.2, 0.25, 0.3, 0.35)}
RATIOS = {"r": 0.5, "zeta": 0.1, "s1": 0.05, "s2": 0.02}


def belt(k=0, **changes):
    return sf.scenes.mass_on_belt(**{"v_b": BELT["v_b"][k % 4], "horizon": 20.0, **changes})


def decaying(k=0):
    t = np.linspace(0.0, 1.0, 401)
    return t, (0.01 + 0.001 * k) * np.exp(-t) * np.cos(30 * t)


def wavy(k=0):
    return sf.scenes.wavy_belt(v_b=0.45, F=5.0 + k, k=100.0)


def shaken(k=0):
    return belt(k, a=0.01, Omega=20.0)


def cycle(k=0):
    return sf.limit_cycle(belt(k))


def drawn(ax):
    """Return what is drawn, as numbers."""
    return [np.asarray(line.get_xydata()) for line in ax.get_lines()]


def tuned(function):
    return lambda k: function(0.05 + 0.01 * k)


def symbolic(function, **options):
    return lambda k: function(symbolic=True, **options)


def own_scene(k):
    m, c = sp.symbols("m c", positive=True)
    system = sf.System(q=[X], u=[U], mass=[[m]], force=[-X - c * U * sp.Abs(U)])
    contact = sf.Contact("pad", slip=U, normal=1 + sp.Abs(X), law=sf.laws.stribeck(0.3, 0.2, 0.1 + 0.01 * k))
    return sf.Scene(system, [contact], {m: 1.0, c: 0.1}, {X: 2.0, U: 0.0}, 15.0)


def map_of(function):
    return lambda k: np.array(function([0.3 + 0.01 * k])["x_max"])


def as_function(k):
    scene = belt(k).wanting({"end": sf.End(), "x_max": sf.Max(X)})
    function = sf.as_function(scene, ["v_b"], ["end", "x_max"], 1e-9)
    return function(0.2 + 0.01 * k), function.jacobian()(0.2, 0, 0)


def run_of(k, **options):
    return sf.simulate(belt(k), **options)


def damped(k):
    return sf.simulate(sf.scenes.contact_damper(f_n=3.5, mu_m=0.1 + 0.01 * k))


def lagrange(k):
    theta = sp.Symbol("theta", real=True)
    w = sp.Symbol("w", real=True)
    system = sf.mechanics.lagrange(kinetic=w**2 / 2, potential=-sp.cos(theta) * (1 + k), q=[theta], u=[w])
    return system.mass, tuple(system.force)


def collocation(k):
    w, x, u = sp.Symbol("w"), *sp.symbols("x u", real=True)
    contact = sf.Contact("floor", u, 1, sf.laws.coulomb(0.1))
    block = sf.Scene(sf.System([x], [u], [[1]], [w]), [contact], {w: 0.0}, {x: 0.0, u: 0.0}, 1.0)
    return sf.design.collocation(
        block, {"w": (-1.0, 1.0)}, {"x": 1.0, "u": 0.0}, time=(0.1, 20.0), elements=3
    ).to_dict()


MODEL = {
    "friction_force": lambda k: sf.friction_force("belt"),
    "stored_energy": lambda k: sf.stored_energy("belt"),
    "dissipated_power": lambda k: sf.dissipated_power("belt"),
    "slip": lambda k: sf.slip("belt"),
    "normal_force": lambda k: sf.normal_force("floor"),
    "stops": lambda k: str(sf.stops(X, -1.0 - k, 1.0, 0.5)),
    "mechanics.against_line": lambda k: str(sf.mechanics.against_line(sf.mechanics.Point(X, k, q=[X], u=[U]))),
    "mechanics.against_circle": lambda k: str(
        sf.mechanics.against_circle(sf.mechanics.Point(X, 0, q=[X], u=[U]), (3, k), 1)
    ),
    "scenes.brake_pad": lambda k: str(sf.scenes.brake_pad(v_b=0.2 + 0.1 * k)),
    "scenes.mass_with_stops": lambda k: str(sf.scenes.mass_with_stops(v0=-5.0 + k)),
    "scenes.impact_oscillator": lambda k: str(sf.scenes.impact_oscillator(e=0.7, zeta=0.05, Omega=2.2 + 0.1 * k)),
    "scenes.cam_follower": lambda k: str(sf.scenes.cam_follower(m=0.5, k=400.0, preload=0.02, h=0.01, Omega=56.0 + k)),
    "scenes.vibratory_conveyor": lambda k: str(sf.scenes.vibratory_conveyor(mu=0.4, a=0.002, Omega=60.0 + k, beta=0.5)),
    "scenes.rocking_block": lambda k: str(sf.scenes.rocking_block(R=1.0, alpha=0.25, theta0=0.1 + 0.01 * k)),
    "mechanics.lagrange": lagrange,
    "patched_floor": lambda k: sf.patched_floor(4.0, 9, 0.01, 0.002, seed=k),
    "control.pid": lambda k: str(sf.control.pid(X, 0, 1 + k, 1, 0.5, every=0.1, limits=(-1, 1))),
    "control.state_feedback": lambda k: str(sf.control.state_feedback([X, U], [1.0, 2.0 + k], every=0.1)),
    "control.friction_compensation": lambda k: str(sf.control.friction_compensation(U, 0.3 + 0.1 * k, every=0.1)),
    "control.pwm": lambda k: str(sf.control.pwm(0.1 * k, every=0.01)),
    "control.dither": lambda k: str(sf.control.dither(0.1, 20 + k, shape="square")),
    "control.discrete": lambda k: str(sf.control.discrete(control.ss(0.9, 0.1, 1.0 + k, 0.0, dt=0.1), [X])),
    "laws.coulomb": lambda k: sf.laws.coulomb(0.4, 0.3 - 0.01 * k)(0.5),
    "laws.lorentz": lambda k: sf.laws.lorentz(0.3, 0.1 + 0.01 * k, 0.4).averaged(0.2)(np.linspace(0.1, 1, 5)),
    "laws.gauss": lambda k: sf.laws.gauss(0.3, 0.1, 0.4)(0.1 * k),
    "laws.square_root": lambda k: sf.laws.square_root(0.3, 0.1, 0.4)(0.1 * k),
    "laws.stribeck": lambda k: sf.laws.stribeck(0.4, 0.3, 0.1).regularised(1e-3 * (k + 1), "tanh")(0.2),
    "laws.cubic": lambda k: sf.laws.cubic(0.4, 0.25, 0.5).averaged(0.1 * (k + 1)).kinetic,
    "laws.exponential": lambda k: sf.laws.exponential(0.3)(0.1 * k),
    "laws.piecewise_linear": lambda k: sf.laws.piecewise_linear(0.4, [0, 0.5], [0.3, 0.2 - 0.01 * k])(0.6),
    "laws.thomsen_regularised": lambda k: sf.laws.thomsen_regularised(0.4, 0.25, 0.5, 0.01 * (k + 1))(0.2),
    "laws.dahl": lambda k: sf.laws.dahl(0.3, 100.0 + k).memory.rates,
    "laws.lugre": lambda k: sf.simulate(belt(k, law=sf.laws.lugre(0.4, 0.3, 0.1, 100.0 + k), horizon=5.0)),
    "laws.elasto_plastic": lambda k: sf.laws.elasto_plastic(0.4, 0.3, 0.1, 10.0, z_ba=0.01 + 0.001 * k).stiffness,
    "laws.maxwell_slip": lambda k: sf.simulate(
        belt(k, law=sf.laws.maxwell_slip([9.0, 4.0], [0.1, 0.2 + 0.01 * k]), horizon=5.0)
    ),
    "laws.rate_and_state": lambda k: sf.laws.rate_and_state(0.6, 0.01, 0.015, 1e-5, 1e-6 * (k + 1)).memory.rates,
    "laws.iwan": lambda k: sf.laws.iwan(1.0 + k, -0.5, 0.1, 4).memory.limits,
    "laws.bouc_wen": lambda k: sf.laws.bouc_wen(10.0, 20.0 + k, 10.0, 2).memory.rates,
    "laws.custom": lambda k: sf.laws.custom(0.3 - 0.01 * k * sf.SPEED, 0.4)(0.6),
    "scenes.absorber": lambda k: sf.scenes.absorber(mass_ratio=0.05, tuning=0.9, damping=0.1 + 0.01 * k).numbers(),
    "scenes.contact_damper": lambda k: sf.scenes.contact_damper(f_n=3.5, mu_m=0.1 + 0.01 * k).numbers(),
    "scenes.coulomb_oscillator": lambda k: sf.scenes.coulomb_oscillator(0.1 + 0.01 * k).numbers(),
    "scenes.drive_slide": lambda k: sf.scenes.drive_slide(
        mu1=-1.0, mu2=0.5, p_star=0.1, epsilon=0.1 + 0.1 * k
    ).numbers(),
    "scenes.drive_stop": lambda k: sf.scenes.drive_stop(mu1=-1.0, mu2=0.5, lam=0.1 + 0.1 * k).numbers(),
    "scenes.mass_on_belt": lambda k: belt(k).equations(),
    "scenes.positioning_stage": lambda k: sf.scenes.positioning_stage(k_p=4.0, k_d=1.0 + k, k_i=1.0).numbers(),
    "scenes.rolling_isolator": lambda k: sf.scenes.rolling_isolator(
        C=1.0, m=10.0, motion=MOTION, profile=([-0.5, 0.0, 0.5], [0.02, 0.03 + 0.01 * k, 0.01])
    ).numbers(),
    "scenes.block_on_incline": lambda k: (
        sf.simulate(sf.scenes.block_on_incline(slope=0.2, mu=0.3, speed=1.0 + k)).final
    ),
    "scenes.friction_pendulum": lambda k: sf.scenes.friction_pendulum(
        R=2.0 + k, mu=0.05, m=10.0, motions=(MOTION, MOTION)
    ).numbers(),
    "scenes.sprung_foundation": lambda k: sf.scenes.sprung_foundation(
        mass_ratio=0.3, stiffness=0.2, damping=0.4 + 0.01 * k
    ).numbers(),
    "scenes.wavy_belt": lambda k: sf.scenes.wavy_belt(v_b=0.4, F=5.0 + k, k=100.0).numbers(),
    "scenes.two_slides": lambda k: sf.scenes.two_slides(**RATIOS, fc1=0.2, fs1=0.3 + 0.01 * k).numbers(),
    "Scene": lambda k: own_scene(k).regularised(1e-3).equations(),
}
MOTIONS = {
    "motions.eurocode8": lambda k: sf.motions.eurocode8(PERIODS),
    "motions.sine_burst": lambda k: sf.motions.sine_burst(1.0 + k, 1.0).samples,
    "motions.random_forcing": lambda k: [s.samples for s in sf.motions.random_forcing(5.0, (0.5, 5.0), 1.0, seed=k)],
    "motions.synthetic": lambda k: sf.motions.synthetic(PERIODS, sf.motions.eurocode8(PERIODS), seed=k).samples,
    "motions.mean_spectrum": lambda k: sf.motions.mean_spectrum([MOTION, MOTION.scaled(pga=2.0 + k)], PERIODS),
    "motions.misfit": lambda k: sf.motions.misfit(MOTION, PERIODS, np.ones(3) + k),
    "motions.scaled_set": lambda k: [m.samples for m in sf.motions.scaled_set([MOTION], 1.0 + k)],
}
THEORY = {
    "export.stepper": lambda k: sf.export.stepper(belt(k), 0.05).run(until=5.0).x.values,
    "theory.falling_speeds": lambda k: sf.theory.falling_speeds(sf.laws.lorentz(0.8, 0.3, b=0.35 + 0.01 * k)),
    "equilibrium": lambda k: sf.equilibrium(belt(k, v_b=0.6)),
    "stability": lambda k: (lambda s: (s, s.hurwitz))(sf.stability(belt(k, v_b=0.6))),
    "hopf": lambda k: sf.hopf(belt(k, beta=0.05 + 0.01 * k), "v_b", (0.2, 0.7)),
    "average": lambda k: sf.average(belt(k)).amplitudes,
    "separate": lambda k: sf.separate(shaken(k)).equations(),
    "theory.damper_loop": lambda k: (lambda g: (g.A, g.B, g.C, g.D))(sf.theory.damper_loop(belt(k, v_b=0.6), "beta")),
    "theory.root_locus": lambda k: sf.theory.root_locus(belt(k, v_b=0.6), "beta", np.linspace(0, 0.3, 5)),
    "theory.stability_of_matrices": lambda k: sf.theory.stability_of_matrices(np.eye(2), np.eye(2) * k, np.eye(2)),
    "theory.symbolic_hurwitz": lambda k: sf.theory.symbolic_hurwitz(belt(k, v_b=0.6)),
    "theory.symbolic_hurwitz_of_matrices": lambda k: sf.theory.symbolic_hurwitz_of_matrices(
        sp.eye(2), sp.diag(*sp.symbols("a b")), sp.eye(2)
    ),
    "theory.hunting": lambda k: sf.theory.hunting(k_p=4.0, k_d=1.0 + 0.1 * k, k_i=1.0, F_s=1.5, F_c=1.0),
    "theory.plane.ball_rolls": lambda k: sf.theory.plane.ball_rolls((1.0 + k, 0.5), (3.0, 0.0), r=0.1, mu=0.2),
    "theory.plane.compare_quenching": lambda k: sf.theory.plane.compare_quenching(
        sf.laws.cubic(0.4, 0.25, 0.5), 0.1 + 0.02 * k
    ),
    "theory.plane.compare_vibration": lambda k: sf.theory.plane.compare_vibration([0.5, 1.0 + k]),
    "theory.plane.disc_expressions": lambda k: sf.theory.plane.disc_expressions(X, U, 1.0 + k, 0.5),
    "theory.plane.disc_stop": lambda k: sf.theory.plane.disc_stop(0.5 + k, 1.0, R=1.0, m=1.0, mu=0.3),
    "theory.plane.disc_stop_ratio": lambda k: sf.theory.plane.disc_stop_ratio(0.4 + 0.05 * k),
    "theory.plane.equal_drag_ratio": lambda k: sf.theory.plane.equal_drag_ratio(1.0 + k),
    "theory.plane.incline_least_speed": lambda k: sf.theory.plane.incline_least_speed(0.3, 0.1 + 0.01 * k, 1.0, 3.0),
    "theory.plane.incline_motion": lambda k: sf.theory.plane.incline_motion(0.3, 0.1 + 0.1 * k, 1.0, 2.0, 1.0),
    "theory.plane.incline_stop": lambda k: sf.theory.plane.incline_stop(0.3, 0.5 + 0.1 * k, 1.0),
    "theory.plane.lateral_vibration_drag": lambda k: sf.theory.plane.lateral_vibration_drag(
        1.0 + k, 0.5, sf.laws.cubic(0.4, 0.25, 0.5)
    ),
    "theory.plane.lateral_vibration_power": lambda k: sf.theory.plane.lateral_vibration_power(1.0 + k, [0.5, 2.0]),
    "theory.plane.longitudinal_vibration_drag": lambda k: sf.theory.plane.longitudinal_vibration_drag(1.0, 0.5 + k),
    "theory.plane.longitudinal_vibration_power": lambda k: sf.theory.plane.longitudinal_vibration_power(
        0.3, 0.5 + k, sf.laws.cubic(0.4, 0.25, 0.5)
    ),
    "theory.plane.spinning_disc_friction": lambda k: sf.theory.plane.spinning_disc_friction([0.1, 1.0 + k], 0.7),
    "theory.plane.steady_power": lambda k: sf.theory.plane.steady_power(sf.laws.coulomb(0.3), 1.0 + k),
    "theory.plane.transverse_damping": lambda k: sf.theory.plane.transverse_damping(sf.laws.coulomb(0.3), 1.0 + k),
    "theory.presliding.dahl_reversal": lambda k: sf.theory.presliding.dahl_reversal(1.0 + k, 10.0, 0.1),
    "theory.presliding.dahl_loop": lambda k: sf.theory.presliding.dahl_loop(1.0 + k, 10.0, 0.1),
    "theory.presliding.lugre_drift": lambda k: sf.theory.presliding.lugre_drift(100.0 + k, 0.2, 0.8),
    "theory.presliding.iwan_backbone": lambda k: sf.theory.presliding.iwan_backbone(1.0 + k, -0.5, 1.0, 0.7),
    "theory.presliding.iwan_dissipation": lambda k: sf.theory.presliding.iwan_dissipation(1.0 + k, -0.5, 0.7),
    "theory.scaling.factors": lambda k: sf.theory.scaling.factors(4.0 + k),
    "theory.scaling.for_table": lambda k: sf.theory.scaling.for_table(3e5, 2e3 + k),
    "theory.scaling.isolator_model": lambda k: sf.theory.scaling.isolator_model(
        sf.theory.scaling.factors(4.0 + k), C=1.0, m=10.0, motion=MOTION, profile=0.02, alpha=2.0
    ).numbers(),
    "theory.scaling.returned_ratio": lambda k: sf.theory.scaling.returned_ratio(1.0 + k, 2.0, 3.0),
    "theory.transient.amplitude_rate": lambda k: sf.theory.transient.amplitude_rate(),
    "theory.transient.averaged_decay_time": lambda k: sf.theory.transient.averaged_decay_time(3.5, 0.1 + 0.01 * k),
    "theory.transient.damper_numbers": lambda k: sf.theory.transient.damper_numbers(
        sf.scenes.contact_damper(f_n=3.5, mu_m=0.1 + 0.01 * k)
    ),
    "theory.transient.decisions": lambda k: sf.theory.transient.decisions(damped(k)),
    "theory.transient.energy_balance": lambda k: sf.theory.transient.energy_balance(damped(k)),
    "theory.transient.half_cycles": lambda k: sf.theory.transient.half_cycles(0.1 + 0.01 * k),
    "theory.transient.mean_friction": lambda k: sf.theory.transient.mean_friction(0.5 + k),
    "theory.transient.stop_position": lambda k: sf.theory.transient.stop_position(0.1 + 0.01 * k),
    "theory.transient.stop_time": lambda k: sf.theory.transient.stop_time(0.1 + 0.01 * k),
    "theory.absorber.decay_rate": lambda k: sf.theory.absorber.decay_rate(0.05, 0.9, 0.1 + 0.01 * k),
    "theory.absorber.peaks": lambda k: sf.theory.absorber.peaks(0.05, 0.9, 0.1 + 0.01 * k),
    "theory.absorber.response": lambda k: sf.theory.absorber.response(0.05, 0.9, 0.1, 0.8 + 0.1 * k),
    "theory.absorber.state_matrix": lambda k: sf.theory.absorber.state_matrix(0.05, 0.9, 0.1 + 0.01 * k),
    "theory.absorber.variance": lambda k: sf.theory.absorber.variance(0.05, 0.9, 0.1 + 0.01 * k),
    "theory.two_lines": lambda k: sf.theory.two_lines([1, 2, 3, 4, 5, 6], [5.0 + k, 3, 1.1, 1.4, 1.7, 2.1]).to_dict(),
    "theory.foundation.at_stiffness": lambda k: sf.theory.foundation.at_stiffness(0.3, 0.2 + 0.1 * k),
    "theory.foundation.break_even": lambda k: sf.theory.foundation.break_even(),
    "theory.foundation.decay_rate": lambda k: sf.theory.foundation.decay_rate(0.3, 0.2, 0.4 + 0.01 * k, -0.1),
    "theory.foundation.state_matrix": lambda k: sf.theory.foundation.state_matrix(0.3, 0.2, 0.4 + 0.01 * k),
    "theory.foundation.widest_stability": lambda k: sf.theory.foundation.widest_stability(0.3 + k),
    "theory.waviness.drag": lambda k: sf.theory.waviness.drag(wavy(k)),
    "theory.waviness.onset_speed": lambda k: sf.theory.waviness.onset_speed(wavy(k)),
    "theory.waviness.sinusoidal_onset_speed": lambda k: sf.theory.waviness.sinusoidal_onset_speed(wavy(k)),
    "theory.waviness.slip_over_a_wave": lambda k: sf.theory.waviness.slip_over_a_wave(0.4, 0.01 * (k + 1)),
    "theory.decay_record.from_turning_points": lambda k: sf.theory.decay_record.from_turning_points(
        [10e-3, 7e-3 + 1e-5 * k, 4e-3], f_n=5.3
    ),
    "theory.decay_record.from_motion": lambda k: sf.theory.decay_record.from_motion(*decaying(k)),
    "theory.drive.damping_matrix": lambda k: sf.theory.drive.damping_matrix(symmetric=bool(k % 2)),
    "theory.drive.definite_condition": lambda k: sf.theory.drive.definite_condition(),
    "theory.drive.hurwitz_conditions": lambda k: sf.theory.drive.hurwitz_conditions(),
    "theory.drive.excess": lambda k: sf.theory.drive.excess(-1.0, 0.5, 1.2 + 0.1 * k),
    "theory.drive.positioning_error": lambda k: sf.theory.drive.positioning_error(-1.0, 0.5, 0.2 + 0.1 * k),
    "theory.drive.single_section_error": lambda k: sf.theory.drive.single_section_error(-0.5, 0.2 + 0.1 * k),
    "theory.drive.steep_error": lambda k: sf.theory.drive.steep_error(-0.5, 0.2 + 0.1 * k),
    "theory.drive.type_limit": lambda k: sf.theory.drive.type_limit(-1.0),
    "theory.drive.slope_limits": lambda k: sf.theory.drive.slope_limits(**RATIOS),
    "theory.drive.threshold": lambda k: sf.theory.drive.threshold(-1.0, 0.5, 0.1),
}
for _name in sf.theory.belt.__all__:
    _function = getattr(sf.theory.belt, _name)
    if callable(_function):
        THEORY[f"theory.belt.{_name}"] = symbolic(_function)
for _name in ("fixed_points", "least_peak", "least_variance", "fastest_decay", "widest_stability"):
    THEORY[f"theory.absorber.{_name}"] = tuned(getattr(sf.theory.absorber, _name))

RUNS = {
    "simulate": run_of,
    "simulate exact": lambda k: sf.simulate(sf.scenes.coulomb_oscillator(0.05 + 0.01 * k)),
    "simulate record": lambda k: sf.simulate(
        sf.scenes.rolling_isolator(C=1.0, m=10.0, motion=MOTION, profile=0.02 + 0.01 * k)
    ),
    "simulate integrators": lambda k: run_of(k, tolerance=1e-6, route="integrators"),
    "map sensitivities": lambda k: (lambda b: (b.final, b.sensitivities, b.output_sensitivities))(
        sf.prepare(belt(k).wanting({"x_max": sf.Max(X)}), sensitivities=["v_b", "x"]).map(
            {"v_b": np.linspace(0.2, 0.3, 20) + 0.01 * k}, threads=2
        )
    ),
    "simulate sensitivities": lambda k: (lambda r: (r, r.sensitivities, r.output_sensitivities))(
        sf.simulate(belt(k).wanting({"x_max": sf.Max(X)}), sensitivities=["v_b", "x"])
    ),
    "prepare": lambda k: sf.prepare(belt(k)).run({"v_b": 0.21 + 0.01 * k}),
    "prepare widened": lambda k: sf.prepare(belt(k)).run({"a": 0.01 + 0.01 * k, "Omega": 3.0}),
    "explain": lambda k: sf.explain(belt(k)).to_dict(),
    "as_function": as_function,
    "Run.plot": lambda k: drawn(run_of(k).plot()),
    "Run.energy_residual": lambda k: run_of(k).energy_residual(),
}
ORBITS = {
    "limit_cycle": lambda k: (lambda o: (o.period, o.half_range, o.multipliers, o.events, o.run))(cycle(k)),
    "continue_cycle": lambda k: (lambda b: (b.values, [s.value for s in b.special]))(
        sf.continue_cycle(belt(k, v_b=0.3), "v_b", (0.28, 0.32 + 0.01 * k))
    ),
    "lyapunov": lambda k: sf.lyapunov(belt(k), 60.0).exponents,
    "poincare": lambda k: sf.poincare(belt(k), "u").states,
    "Orbit.plot": lambda k: drawn(cycle(k).plot()),
}
T, LONG = np.linspace(0.2, 18.0, 60), np.linspace(0.0, 60.0, 2000)
C, D = sp.symbols("c d", positive=True)


def record_of(k):
    return {"x": (T, run_of(k)(T)[0] + 0.001 * np.sin(T**2))}


def fitted(k):
    return sf.identify(belt(k, beta=0.04), record_of(k), {"beta": (0.01, 0.2)}, starts=2)


def compared(k):
    scenes = {"light": belt(k, beta=0.04), "heavy": belt(k, beta=0.04, gamma2=1.2)}
    return sf.compare_laws(scenes, record_of(k), {"beta": (0.01, 0.2)}, starts=1).to_dict()


def sampled(k):
    return sf.sweep(
        belt(k).wanting({"x_max": sf.Max(X)}), sf.CaseTable({"v_b": [0.1, 0.2], "beta": [0.01, 0.02 + 0.01 * k]})
    )


ENSEMBLE = {
    "sweep": lambda k: sf.sweep(
        belt(k).wanting({"x_max": sf.Max(X)}), {"v_b": np.linspace(0.1, 0.3, 4), "beta": [0.0, 0.01 * (k + 1)]}, jobs=2
    ),
    "identify": lambda k: fitted(k).to_dict(),
    "compare_laws": compared,
    "fit_curve": lambda k: sf.fit_curve(
        sf.laws.coulomb(C, D), [0.1, 0.2, 0.3], [0.3, 0.31, 0.3 + 0.01 * k], {"c": (0, 1), "d": (0, 1)}, static=0.4
    ).to_dict(),
    "fit_decay": lambda k: sf.fit_decay(LONG, np.exp(-0.02 * LONG) * np.cos(LONG + 0.1 * k), ["viscous"]).to_dict(),
    "fit_loop": lambda k: sf.fit_loop(
        sf.laws.dahl(C, 100.0 + k), [0.0, 0.01, 0.02, 0.01], [0.0, 0.28, 0.3, -0.2], {"c": (0.1, 1.0)}
    ).to_dict(),
    "draw": lambda k: sf.draw({"v_b": scipy.stats.uniform(0.1, 0.2 + 0.01 * k)}, 8, seed=k).columns,
    "probability": lambda k: sf.probability(sampled(k)["x_max"], above=0.4),
    "plot_probability": lambda k: drawn(sf.plot_probability(sampled(k)["x_max"])),
    "spread": lambda k: sf.spread(sampled(k)),
    "test_design": lambda k: sf.test_design(fitted(k), {"v_b": [0.1, 0.3]}).to_dict(),
    "basins": lambda k: sf.basins(belt(k), {"x": np.array([0.0, 1.0])}).to_xarray(),
    "bifurcation_diagram": lambda k: sf.bifurcation_diagram(belt(k), "v_b", [0.2, 0.3 + 0.01 * k], "u", jobs=2).states,
}
BOUNDS = {"Omega": (20.0, 60.0), "a": (0.0, 0.1)}
SLIDES = {"r": 1.0, "zeta": 0.1, "s1": 0.3, "s2": 0.1}
SLOW = {
    "continue_special": lambda k: sf.continue_special(
        sf.continue_cycle(belt(v_b=0.3), "v_b", (0.3, 0.45)).special[0], ("v_b", "beta"), ((0.3, 0.5), (0.045, 0.055))
    ).to_dict(),
    "theory.drive.two_slides_threshold": lambda k: sf.theory.drive.two_slides_threshold(**SLIDES),
    "theory.drive.two_slides_onset": lambda k: sf.theory.drive.two_slides_onset(**SLIDES),
    "theory.drive.two_slides_cycle": lambda k: sf.theory.drive.two_slides_cycle(**SLIDES, fs1=9.0),
    "theory.drive.two_slides_thresholds": lambda k: sf.theory.drive.two_slides_thresholds(
        "zeta", [0.1, 0.11], r=1.0, s1=0.3, s2=0.1
    ),
    "design.absorber": lambda k: sf.design.absorber(0.05 + 0.01 * k, "h2").to_dict(),
    "design.sprung_foundation": lambda k: sf.design.sprung_foundation(0.3 + k).to_dict(),
    "design.quench": lambda k: sf.design.quench(belt(k), speeds=(0.0, 0.3), **BOUNDS).to_dict(),
    "design.damper": lambda k: sf.design.damper(belt(k), "beta", (0.0, 1.0), (0.3, 0.45)).to_dict(),
    "design.positioning": lambda k: sf.design.positioning(
        sf.scenes.drive_slide(mu1=-0.25, mu2=0.125, p_star=0.5, epsilon=0.1, sigma=0.1), "sigma", (0, 1), (1.25, 5)
    ).to_dict(),
    "design.controller": lambda k: sf.design.controller(
        sf.scenes.positioning_stage(k_p=4.0, k_d=2.0, k_i=1.0, x0=0.5, horizon=120.0), "k_i", (0.5, 7.0), half_range=0.1
    ).to_dict(),
    "design.contact_damper": lambda k: sf.design.contact_damper(
        sf.scenes.contact_damper(f_n=3.5, mu_m=0.1), {"f_n": (1.0, 12.0)}
    ).to_dict(),
    "design.isolator": lambda k: sf.design.isolator(
        sf.scenes.rolling_isolator(C=1.0, m=10.0, motion=MOTION, profile=0.01), [MOTION], {"mu": (0.005, 0.05)}
    ).to_dict(),
    "design.collocation": collocation,
}
OMEGA = sp.Symbol("Omega", positive=True)


def response(k):
    structure = sf.structures.Structure([[1.0]], [[1.0]], [[0.2 + 0.02 * k]], names=["x1"])
    scene = structure.scene([], {"x1": sp.cos(OMEGA * sf.TIME)}, {OMEGA: 0.95}, horizon=80.0)
    return sf.frequency_response(scene, "Omega", (0.9, 1.1)).peak.half_range


def beginning(k):
    speed = sp.Symbol("v_b", positive=True)
    pad = sf.structures.RowContact("pad", {"x1": 1.0}, 1.0, sf.laws.cubic(0.4, 0.25, 0.5), speed=speed)
    chain = sf.structures.chain(1, damping=0.05 + 0.01 * k, ends="fixed-free")
    found = sf.structures.onset(chain.scene([pad], values={speed: 0.3}), "v_b", (0.3, 0.7), (0.44, 0.7), most=2)
    return [found.hopf.value, *found.branch.values]


STRUCTURES = {
    "frequency_response": response,
    "structures.onset": beginning,
    "structures.disc_and_pad": lambda k: sf.structures.disc_and_pad(20 + 2 * k).structure.K.diagonal(),
    "structures.beam": lambda k: sf.structures.beam(4 + k, load="follower").modes(2).frequency,
    "structures.chain": lambda k: sf.structures.chain(5 + k).modes(2).frequency,
    "structures.ziegler": lambda k: sf.structures.ziegler(damping=0.1 * k).complex_modes(2, mu=1.0).eigenvalues,
    "structures.flutter": lambda k: sf.structures.flutter(sf.structures.ziegler(), (0, 3 + k), count=2).critical[0].mu,
    "structures.sliding": lambda k: (lambda s: (s.K.toarray(), s.friction.toarray()))(
        sf.structures.sliding(
            sf.structures.chain(4),
            [
                sf.structures.RowContact(
                    "pad",
                    {"x1": 1.0},
                    sf.structures.RowLoad(1.0, {"x2": 0.1 * (k + 1)}, {"x2": -1.0}),
                    sf.laws.coulomb(0.3),
                    speed=1.0,
                )
            ],
        )
    ),
    "structures.flutter_map": lambda k: (
        sf.structures.flutter_map(
            lambda c: sf.structures.ziegler(damping=c), [0.1, 0.2 + 0.1 * k], mu=(0.5, 3.0), count=2, name="c"
        ).mu
    ),
}
CALLS = {**MODEL, **MOTIONS, **THEORY, **RUNS, **ORBITS, **ENSEMBLE, **STRUCTURES}
