"""What does an earthquake do to a building on rollers, and how far does it stand off afterwards?

300 t on rolling friction 0.005 with a damper of 100 kN s/m; three artificial motions of El Centro's peak, 0.32 g. For a
record take `sf.motions.read_at2("file.AT2")`.
No published value was found to compare with: the motions are artificial. Between two samples the motion is exact.
"""

import numpy as np

import symfric as sf

PGA = 0.32  # g, as El Centro 1940

motions = [sf.motions.synthetic(seed=k, pga=PGA, unit="g", duration=20.0) for k in range(3)]
for profile, words in ((0.005, "even floor"), ((0.005, 0.05), "friction that rises by 0.05 a metre")):
    rows = []
    for motion in motions:
        run = sf.simulate(sf.scenes.rolling_isolator(C=1e5, m=3e5, motion=motion, profile=profile))
        rows.append([run["peak_acceleration"] / 9.81, run["peak_displacement"], abs(run["residual"])])
    acceleration, way, rest = np.mean(rows, axis=0)
    print(f"{words}: {acceleration:.3f} g instead of {PGA} g, moves {way:.3f} m, {1000 * rest:.1f} mm off in the end")
