"""Orbits of w'' + 2 mu(w) w' + w = 0 through a corner by (17) and (18) alone, with 30 digits.

The equations for `threshold` stand in `drawn`, those for `error` in `derivations.guida.error`.
"""

from functools import cache

import mpmath


def log_psi(u, mu):
    """Return ln psi of (18) for any damping, as an mpmath number; the arctangent is the principal one."""
    one = 1 - mu**2
    if one > 0:
        root = mpmath.sqrt(one)
        return -mpmath.log(u**2 + 2 * mu * u + 1) / 2 + mu / root * mpmath.atan((u + mu) / root)
    if one == 0:
        return -mu / (u + mu) - mpmath.log(abs(u + mu))
    q = mpmath.sqrt(-one)
    return -mpmath.log(abs(u**2 + 2 * mu * u + 1)) / 2 + mu / (2 * q) * mpmath.log(abs((u + mu - q) / (u + mu + q)))


def side(level, mu, sign, low=0):
    """Return the u of a sign, beyond `low` in size, at which ln psi has a value; found as 1/u = z."""
    a, b = mpmath.mpf(0), (1 / mpmath.mpf(low) if low else mpmath.mpf(10) ** 60)
    for _ in range(400):
        z = mpmath.sqrt(a * b) if a > 0 else b * mpmath.mpf(10) ** -80
        if log_psi(sign / z, mu) > level:
            b = z
        else:
            a = z
        if a > 0 and b - a < mpmath.mpf(10) ** -35 * b:
            break
    return sign / b


@cache
def threshold(mu1, mu2, p_star):
    """Return eps_crit, in the scaling by v*, from (18), with 30 digits; |mu1| < 1, 0 < mu2 < 1, p* < 0."""
    with mpmath.workdps(40):
        mu1, mu2, place = (mpmath.mpf(e) for e in (mu1, mu2, p_star))
        down = side(log_psi(mpmath.mpf(0), mu1) + mpmath.log(-place), mu1, 1)
        up = side(log_psi(down, mu2) - 2 * mpmath.pi * mu2 / mpmath.sqrt(1 - mu2**2), mu2, -1)
        start = log_psi(up, mu1) - mpmath.log(-place)
        if start >= log_psi(mpmath.mpf(0), mu1):
            return mpmath.mpf(0)
        return -side(start, mu1, -1) / (1 + place)


@cache
def error(mu1, mu2, lam):
    """Return Delta S and whether the corner is passed, from (18), with 30 digits; mu1 < 1."""
    with mpmath.workdps(40):
        mu1, mu2, lam = (mpmath.mpf(e) for e in (mu1, mu2, lam))
        turn = mu1 * mpmath.pi / (2 * mpmath.sqrt(1 - mu1**2)) if abs(mu1) < 1 else mpmath.mpf(0)
        level = turn - mpmath.log(lam)  # -ln C
        if abs(mu1) < 1 and log_psi(mpmath.mpf(0), mu1) <= level:
            return lam + lam * mpmath.exp(-2 * turn), False
        low = -mu1 + mpmath.sqrt(mu1**2 - 1) if mu1 <= -1 else 0
        up = side(level, mu1, 1, low)
        slow = mu2 - mpmath.sqrt(mu2**2 - 1) if mu2 >= 1 else None
        down = bounded(log_psi(up, mu2), mu2, slow) if slow else side(log_psi(up, mu2), mu2, -1)
        return lam + mpmath.exp(-turn - log_psi(down, mu1)), True


@cache
def moving_error(mu1, mu2, speed, sigma):
    """Return Delta S of a slide that has the drive's speed V > 1 at the stop; |mu1| < 1, 0 < mu2 < 1.

    `sigma` is that of a damper on the support, whose force 2 sigma V sets in with the stop; 0 if it is to ground.
    """
    with mpmath.workdps(40):
        mu1, mu2, speed, sigma = (mpmath.mpf(e) for e in (mu1, mu2, speed, sigma))
        lam = 2 * (mu1 - sigma) + 2 * (mu2 - sigma) * (speed - 1)
        down = side(log_psi(-2 * sigma, mu2) - mpmath.log(speed), mu2, -1, 2 * sigma)
        turn = mu1 * mpmath.pi / (2 * mpmath.sqrt(1 - mu1**2))
        return lam + mpmath.exp(-turn - log_psi(down, mu1))


def bounded(level, mu, slow):
    """Return the u between -slow and 0 at which ln psi has a value; ln psi rises there from minus infinity."""
    a, b = -slow, mpmath.mpf(0)
    for _ in range(140):
        middle = (a + b) / 2
        a, b = (a, middle) if log_psi(middle, mu) > level else (middle, b)
    return (a + b) / 2
