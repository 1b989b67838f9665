"""A drawn slide of the positioning designs: its threshold of stick-slip and its error after an abrupt stop."""

from dataclasses import dataclass

import numpy as np

from symfric.theory.drive import excess, positioning_error, threshold


@dataclass(frozen=True)
class Slide:
    """Parameters of `symfric.scenes.drive_slide`, forces over ``m omega_n v*``.

    Attributes
    ----------
    mu1, mu2 : float
        Half the slopes of the friction characteristic without the damper.
    epsilon, sigma : float
    damper : str
    """

    mu1: float
    mu2: float
    epsilon: float
    sigma: float
    damper: str

    def threshold(self, V: float) -> float:
        """Return the least friction difference with stick-slip at a speed V = v/v*."""
        return threshold(self.mu1 + self.sigma, self.mu2 + self.sigma, 1 / V - 1)

    def excess(self, V: float) -> float:
        """Return lambda at a speed V."""
        mu1, mu2 = self.mu1 + self.sigma, self.mu2 + self.sigma
        return excess(mu1, mu2, V, damper=self.damper, sigma=self.sigma)

    def error(self, V: float) -> float:
        """Return the positioning error at a speed V, over v*/omega_n."""
        mu1, mu2 = self.mu1 + self.sigma, self.mu2 + self.sigma
        return positioning_error(mu1, mu2, self.excess(V), epsilon=self.epsilon).value

    def slack(self, V: float) -> float:
        """Return a test function of stick-slip at V, from -1 to 1, negative with stick-slip.

        A threshold of zero means that the slide sticks again after every release, also without a static excess.
        """
        limit = self.threshold(V)
        if not np.isfinite(limit):
            return 1.0
        return -1.0 if limit == 0 else (limit - self.epsilon) / (limit + self.epsilon)
