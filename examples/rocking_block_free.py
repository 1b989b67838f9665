"""How long does a tilted block take to swing back, and how much does the impact of its edge take from it?

Housner (Bulletin of the Seismological Society of America 53, 1963, 403), for a slender block with p^2 = 3 g/(4 R): a
quarter of the period is arccosh(1/(1 - theta_0/alpha))/p, and an impact leaves 1 - 1.5 sin^2(alpha) of the speed of
rotation. Here the whole block moves, with two corners that open, strike and may slide.
"""

from math import acosh, sin

import symfric as sf

R = 0.75 * 9.81 / 2.0**2  # m, so that p = 2 rad/s
motions = {}
for alpha in (0.2, 0.1):  # rad
    block = sf.scenes.rocking_block(R=R, alpha=alpha, mu=2.0, theta0=alpha / 2, horizon=8.0)
    angle = next(q for q in block.system.q if q.name == "theta")
    rate = block.system.u[block.system.q.index(angle)]
    run = sf.simulate(block.wanting({"path": sf.Trajectory(), "events": sf.Events()})).checked()
    motions[alpha] = run, list(run.names).index(angle.name)
    hit = next(event.t for event in run.events if event.kind in ("impact", "close"))
    kept = abs(run(hit + 1e-7)[list(run.names).index(rate.name)] / run(hit - 1e-7)[list(run.names).index(rate.name)])
    print(f"alpha = {alpha:g}: quarter period {hit:.4f} s, slender {acosh(2) / 2:.4f} s; ", end="")
    print(f"keeps {kept:.5f} of its speed, Housner {1 - 1.5 * sin(alpha) ** 2:.5f}")
