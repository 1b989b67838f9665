"""The impact oscillator of P15 in closed form between its impacts, to any number of digits."""

import mpmath as mp

from symfric.model.scene import Scene

_LOOK = 0.02  # between the times at which the distance from the stop is looked at
_SPARE = 10  # digits beyond those asked for


def closed_motion(scene: Scene, digits: int = 24) -> tuple[tuple[mp.mpf, mp.mpf], int]:
    r"""Return the state at the horizon and the number of impacts.

    Parameters
    ----------
    scene : Scene
        `symfric.scenes.impact_oscillator` with the stop at x = 0 and F = 1; its floats are taken as they are.
    digits : int
        That are right.

    Notes
    -----
    With the response :math:`\mathrm{Re}\,G e^{i\Omega t}`, :math:`G = 1/(1 - \Omega^2 + 2 i \zeta\Omega)`, what is left
    of the state after an impact decays freely with :math:`e^{-\zeta t}` and the frequency :math:`\sqrt{1 - \zeta^2}`.
    """
    given = {s.name: v for s, v in scene.numbers().items()}
    with mp.workdps(digits + _SPARE):
        z, w, e = (mp.mpf(float(given[name])) for name in ("zeta", "Omega", "e"))
        gain, own, end = 1 / mp.mpc(1 - w * w, 2 * z * w), mp.sqrt(1 - z * z), mp.mpf(scene.horizon)
        t, x, v, impacts = mp.mpf(0), mp.mpf(float(given["x"])), mp.mpf(float(given["u"])), 0
        while True:
            driven = gain * mp.expj(w * t)
            a, b = x - driven.real, v - (mp.j * w * driven).real
            b = (b + z * a) / own

            def place(s: mp.mpf, t: mp.mpf = t, a: mp.mpf = a, b: mp.mpf = b) -> tuple[mp.mpf, mp.mpf]:
                driven, decay = gain * mp.expj(w * (t + s)), mp.exp(-z * s)
                c, d = mp.cos(own * s), mp.sin(own * s)
                free = decay * (a * c + b * d)
                rate = decay * own * (b * c - a * d) - z * free
                return driven.real + free, (mp.j * w * driven).real + rate

            s = mp.mpf(_LOOK) / 16
            while t + s < end and place(s)[0] < 0:
                s += _LOOK
            if t + s >= end and place(end - t)[0] < 0:
                return place(end - t), impacts
            low, high = max(s - _LOOK, mp.mpf(_LOOK) / 16), s
            s = mp.findroot(lambda s, place=place: place(s)[0], (low, high), solver="anderson")
            t, x, v, impacts = t + s, mp.mpf(0), -e * place(s)[1], impacts + 1
