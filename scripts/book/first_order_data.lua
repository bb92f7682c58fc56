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

local figure = pl.figure{title = "Data of a first-order system", x = {label = "time t [s]", limits = {0, 15}}}
figure:panel{y = "output y"}:line(data.time, y, {color = "blue"})
figure:panel{y = "input u", height = 0.5}:stairs(data.time, u, {color = "grey"})
figure:save("out/figure_2_5." .. format)

-- Every sample lies in the plane y(k) = 0.9512 y(k-1) + 0.09754 u(k-1): over y(k-1), for each of both inputs, a line.
local X, target = identify.regressors(data, "y(k-1), u(k-1)")
figure = pl.figure{title = "The samples lie in one plane", x = "y(k-1)", y = "y(k)"}
for _, level in ipairs{1, -1} do
  local x, z = {}, {}
  for k = 1, #target do
    if X(k, 2) == level then
      x[#x + 1], z[#z + 1] = X(k, 1), target[k]
    end
  end
  local color = level == 1 and "blue" or "vermillion"
  figure:markers(x, z, {label = ("u(k-1) = %d"):format(level), color = color})
  figure:line({-2, 2}, {0.9512 * -2 + 0.09754 * level, 0.9512 * 2 + 0.09754 * level}, {color = color})
end
figure:save("out/figure_2_6." .. format)

local model = identify.arx(data, {na = 1, nb = 1})
print(("least squares: a1 = %.10f, b1 = %.10f, gain %.4f"):format(model.A[2], model.B[1], model.gain))
