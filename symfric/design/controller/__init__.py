"""The largest gain, sampling period or dead time with which a controlled motion comes to rest instead of hunting."""
