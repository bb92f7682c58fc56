-- What do data of a first-order system say, and what does least squares make of them?
--
-- Figures 2.5 and 2.6 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods (2023):
-- equation (2.6), y(k) = 0.9512 y(k-1) + 0.09754 u(k-1), a gain of 2 and a time constant of 1 s sampled every 0.05 s.
-- plantloop script scripts/book/first_order_data.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local levels = identify.staircase{samples = 60, hold = 1, lower = -1, upper = 1, seed = 26}
local u, y = pl.zeros(300), pl.zeros(300)
for k = 1, 300 do
  u[k] = levels[(k - 1) // 5 + 1] < 0 and -1 or 1
  if k > 1 then y[k] = 0.9512 * y[k - 1] + 0.09754 * u[k - 1] end
end
local data = identify.data{u = u, y = y, Ts = 0.05}

-- The signals (left), and where in the plane of the regressors the samples lie (right).
local X, target = identify.regressors(data, "y(k-1), u(k-1)")
local past_y, past_u = X:column(1), X:column(2)
local figure = pl.figure{title = "Data of a first-order system", columns = 2}
local time = {label = "time t [s]", limits = {0, 15}}
figure:panel{x = time, y = "output y"}:line(data.time, y, {color = "blue"})
figure:panel{x = {label = "y(k-1)", limits = {-1.5, 1.5}}, y = "y(k)"}:markers(past_y, target, {color = "grey", size = 3})
figure:panel{x = time, y = "input u"}:stairs(data.time, u, {color = "grey"})
figure:panel{x = {label = "y(k-1)", limits = {-1.5, 1.5}}, y = "u(k-1)"}:markers(past_y, past_u, {color = "grey", size = 3})
figure:save("out/figure_2_5." .. format)

-- Every sample lies in the plane of the model.
local model = identify.arx(data, {na = 1, nb = 1})
local side_y, side_u, plane = pl.linspace(-1.5, 1.5, 13), pl.linspace(-1.2, 1.2, 13), {}
for i = 1, 13 do
  plane[i] = {}
  for j = 1, 13 do plane[i][j] = -model.A[2] * side_y[j] + model.B[1] * side_u[i] end
end
figure = pl.figure{title = "The model is a plane, and the samples lie in it", x = "y(k-1)", y = "u(k-1)"}
figure:surface(pl.matrix(plane), side_y, side_u, {points_x = past_y, points_y = past_u, points_z = target, z_label = "y(k)"})
figure:save("out/figure_2_6." .. format)
local off = pl.max(pl.abs(target + model.A[2] * past_y - model.B[1] * past_u))
print("all samples lie in the plane of the model: " .. (off < 1e-12 and "yes" or ("no, up to %g off"):format(off)))
print(("least squares: a1 = %.10f, b1 = %.10f, gain %.4f"):format(model.A[2], model.B[1], model.gain))
