"""How hard must a creaking door hinge be shaken to be quiet?

In the units of the mass on a belt: static friction 0.4, least 0.25 at speed 0.5, damping ratio 0.05.
"""

import symfric as sf

door = sf.scenes.mass_on_belt(v_b=0.2, beta=0.05)
print(f"it creaks below a speed of {sf.theory.belt.onset_speed(door):.4f}")
print(f"shaking of intensity {sf.theory.belt.quench_intensity(door):.4f} ends that at every speed")

found = sf.design.quench(door, speeds=(0.1, 0.4), Omega=(20, 60), a=(0.0, 0.02))
print(f"designed on the full model: a = {found.values['a']:.4f}, Omega = {found.values['Omega']:.1f}")

quiet = sf.simulate(door.where(found.values).wanting({"fast": sf.HalfRange(door.system.q[0])})).checked()
print(f"what is left: half range {quiet['fast']:.4f}, the start included")
