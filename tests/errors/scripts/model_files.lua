-- Files that are no models, or other ones than they say.
local identify = pl.identify
local u, y = identify.prbs{bits = 6}, pl.zeros(63)
for k = 2, 63 do y[k] = 0.8 * y[k - 1] + 0.5 * u[k - 1] end
local data = identify.data{u = u, y = y, Ts = 0.1}
says(identify.load, "empty.yaml")
says(identify.load, "comments.yaml")
says(identify.load, "structure.yaml")
says(identify.state_space, identify.data{u = u, y = pl.zeros(63), Ts = 0.1}, {order = 1})
