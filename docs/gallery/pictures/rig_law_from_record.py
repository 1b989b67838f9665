"""The record of the gauge and the motion of the fitted scene."""

import matplotlib.pyplot as plt

ax = plt.figure().add_subplot()
fit.plot(ax)
