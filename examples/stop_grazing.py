"""What happens to a vibration that grows until it just touches a stop?

A lightly damped mass (x'' + 0.1 x' + x = F cos 0.8 t) has a stop at x = 1. Where the orbit begins to touch, it is not
the amplitude that jumps but the stability: what follows has the square root of the distance in it.
"""

from math import pi, sqrt

import symfric as sf

zeta, Omega = 0.05, 0.8
scene = sf.scenes.impact_oscillator(e=0.7, zeta=zeta, Omega=Omega, F=0.3, gap=1.0)
touches = sqrt((1 - Omega**2) ** 2 + (2 * zeta * Omega) ** 2)  # of the linear orbit, whose amplitude is the gap
print(f"the linear orbit touches at F = {touches:.6f}")

period = 2 * pi / Omega

free = sf.limit_cycle(scene.where({"F": 0.99 * touches}))
print(f"1 % below it vibrates with the period of the force, largest multiplier {max(abs(free.multipliers)):.3f}")
for more in (1.001, 1.01, 1.1):
    run = sf.simulate(scene.where({"F": more * touches}).until(400 * period))
    late = [event for event in run.events if event.t > 300 * period]
    print(f"{100 * (more - 1):.1f} % above: an impact every {100 / len(late):.2f} periods of the force")
