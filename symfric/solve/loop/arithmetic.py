"""The statements that the event loop shares with lanes, for compiled code; see `.statements`."""

from symfric.codegen.numba_types import shared
from symfric.solve.loop import statements

area = shared(statements.area)
box_of_step = shared(statements.box_of_step)
defect_of_rate = shared(statements.defect_of_rate)
defect_of_value = shared(statements.defect_of_value)
doubted_force = shared(statements.doubted_force)
drifts = shared(statements.drifts)
instant = shared(statements.instant)
is_at_rest = shared(statements.is_at_rest)
is_still = shared(statements.is_still)
largest_of_row = shared(statements.largest_of_row)
little_acceleration = shared(statements.little_acceleration)
logarithm = shared(statements.logarithm)
natural_time = shared(statements.natural_time)
no_acceleration = shared(statements.no_acceleration)
power_of_two = shared(statements.power_of_two)
scale_of_state = shared(statements.scale_of_state)
size_of_row = shared(statements.size_of_row)
slope = shared(statements.slope, inline=False)  # long, and called where a step seldom comes
stick_scale = shared(statements.stick_scale)
summed = shared(statements.summed)
value = shared(statements.value)
value_and_slope = shared(statements.value_and_slope, fused=False)
