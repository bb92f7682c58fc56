-- How sure is a Gaussian process of what it says, inside of its data and outside?
--
-- Figures 7.1 to 7.3 and 7.5 to 7.11 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
-- (2023): the function (7.15) from eight noisy points, and the system (7.20) = (3.9) from 100 of 300 samples. The book's points
-- are not printed; these are drawn anew.
-- plantloop script scripts/book/gaussian_process.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local function save(figure, number) figure:save(("out/figure_7_%s.%s"):format(number, format)) end
local function yes(holds) return holds and "yes" or "no" end

-- (7.15) with noise of variance 0.0025 at eight points.
local points = pl.vector{0.03, 0.10, 0.38, 0.51, 0.56, 0.68, 0.74, 0.95}
local targets = pl.vector{0.914, 0.477, -0.157, -0.310, -0.429, -0.233, -0.162, 0.684}
local function f(x) return 4 * x ^ 2 + x - 6 * pl.sin(x) + 1 end
local x = pl.linspace(0, 1.2, 121)
local few = identify.data{u = points, y = targets, Ts = 1}
local static = identify.gaussian_process(few, {regressors = "u(k)", starts = 10, seed = 1})
local mean, variance = static:uncertain(identify.data{u = x, y = f(x), Ts = 1}, {propagation = "naive"})
local deviation = variance ^ 0.5

-- What a process is (figure 7.1): at each x a normal density, narrow near data.
local figure = pl.figure{title = "A process says a density of y for each x", columns = 2}
local left, right = figure:panel{x = {label = "x", limits = {0, 1.2}}, y = "y"}, figure:panel{x = {label = "y", limits = {-1.2, 2.4}}, y = "density of y"}
left:band(x, mean - 2 * deviation, mean + 2 * deviation, {color = "sky"})
left:line(x, mean, {color = "blue", label = "mean"})
left:markers(points, targets, {color = "vermillion", label = "data"})
local level = pl.linspace(-1.2, 2.4, 361)
for _, c in ipairs{{51, "blue"}, {96, "green"}, {121, "vermillion"}} do
  local m, s = mean[c[1]], deviation[c[1]]
  right:line(level, pl.exp(-0.5 * ((level - m) / s) ^ 2) / (s * math.sqrt(2 * pl.pi)), {color = c[2], label = ("x = %.2f"):format(x[c[1]])})
  left:line(pl.vector{x[c[1]], x[c[1]]}, pl.vector{m - 2 * s, m + 2 * s}, {color = c[2]})
end
save(figure, 1)
figure = pl.figure{title = "A function and eight noisy points", x = "x", y = "y"}
figure:line(x, f(x), {color = "grey", label = "f(x)"})
figure:markers(points, targets, {color = "vermillion", label = "data"})
save(figure, 2)
figure = pl.figure{title = "What the process makes of them: mean and two standard deviations", x = "x", y = "y"}
figure:band(x, mean - 2 * deviation, mean + 2 * deviation, {color = "blue"})
figure:line(x, mean, {color = "blue", label = "mean"})
figure:line(x, f(x), {color = "grey", label = "f(x)"})
figure:markers(points, targets, {color = "vermillion", label = "data"})
save(figure, 3)
print("static: outside of the data three times less sure than inside: " .. yes(deviation[121] > 3 * deviation[51]))
print("static: the error stays within two deviations nearly everywhere: " .. yes(identify.metrics(f(x), mean, {variance = variance}).coverage > 0.85))

-- (7.20): targets with noise of 0.05, regressors without: every row is an experiment of two samples.
local function staircase(samples, hold, lower, upper, seed)
  local u, y = identify.staircase{samples = samples, hold = hold, lower = lower, upper = upper, seed = seed}, pl.zeros(samples)
  for k = 2, samples do
    local e = math.exp(2 * (y[k - 1] + u[k - 1] ^ 3))
    y[k] = y[k - 1] - 0.5 * (e - 1) / (e + 1)
  end
  return u, y
end
local u, y = staircase(300, 4, -1.3, 1.3, 5)
local noise = identify.white_noise{samples = 300, deviation = 0.05, seed = 6}
local rows, ys, us = {}, {}, {}
for k = 2, 300 do
  rows[#rows + 1] = identify.data{u = u:slice(k - 1, k), y = pl.vector{y[k - 1], y[k] + noise[k]}, Ts = 0.5}
  us[#us + 1], ys[#ys + 1] = u[k - 1], y[k - 1]
end
local process = identify.gaussian_process(identify.join(table.unpack(rows)), {regressors = "y(k-1), u(k-1)", starts = 4, points = 100, seed = 2})
local function judge(number, ru, ry, title)
  local record = identify.data{u = ru, y = ry, Ts = 0.5}
  local m, v = process:uncertain(record, {propagation = "moment_matching"})
  local naive_m, naive_v = process:uncertain(record, {propagation = "naive"})
  local s = (v + 0.0025) ^ 0.5
  figure = pl.figure{title = title, x = "time t [s]"}
  local top = figure:panel{y = "y"}
  top:band(record.time, m - 2 * s, m + 2 * s, {color = "blue"})
  top:line(record.time, ry, {color = "grey", label = "system"})
  top:line(record.time, m, {color = "blue", label = "free run"})
  figure:panel{y = "u", height = 0.4}:stairs(record.time, ru, {color = "grey"})
  save(figure, number)
  local errors = identify.metrics(ry, m, {skip = 1, variance = v + 0.0025})
  print(("%s: AE %.3f, SE %.4f, LD %.2f"):format(title, errors.AE, errors.SE, errors.LD))
  print("  carrying uncertainty along makes it less sure: " .. yes(pl.mean(v) >= pl.mean(naive_v)))
  return record, v, naive_v, errors
end
judge(5, u, y, "Identification")
local inside_u, inside_y = staircase(100, 8, -1.2, 1.2, 7)
local _, _, _, errors = judge(8, inside_u, inside_y, "Validation inside of the data")
print("  AE below 0.06, SE below 0.008, LD from -2.2 to -0.9: " .. yes(errors.AE < 0.06 and errors.SE < 0.008 and errors.LD > -2.2 and errors.LD < -0.9))
local beyond_u, beyond_y = staircase(100, 8, -1.3, 1.5, 8)
local record, v, naive_v = judge(9, beyond_u, beyond_y, "Validation that leaves the data")
figure = pl.figure{title = "Standard deviation of the free run that leaves the data", x = "time t [s]", y = "standard deviation"}
figure:line(record.time, v ^ 0.5, {color = "blue", label = "moment matching"})
figure:line(record.time, naive_v ^ 0.5, {color = "grey", label = "naive"})
save(figure, 10)
-- One step from any state, as a record of pairs: surfaces (figure 7.6), contours (7.7), deviation and data (7.11).
local side_u, side_y = pl.linspace(-1.6, 1.6, 33), pl.linspace(-1.7, 1.7, 33)
local pu, py = {}, {}
for j = 1, 33 do
  for i = 1, 33 do
    pu[#pu + 1], pu[#pu + 2] = side_u[i], 0
    py[#py + 1], py[#py + 2] = side_y[j], 0
  end
end
local answers = process:predict(identify.data{u = pl.vector(pu), y = pl.vector(py), Ts = 0.5}, 1)
local function grid(value)
  local all = {}
  for j = 1, 33 do
    all[j] = {}
    for i = 1, 33 do all[j][i] = value(i, j) end
  end
  return pl.matrix(all)
end
local of_model = grid(function(i, j) return answers[2 * ((j - 1) * 33 + i)] end)
local of_system = grid(function(i, j)
  local e = math.exp(2 * (side_y[j] + side_u[i] ^ 3))
  return side_y[j] - 0.5 * (e - 1) / (e + 1)
end)
figure = pl.figure{title = "The next output: system (left), and process with its data (right)", columns = 2}
figure:panel{x = "u(k-1)", y = "y(k-1)"}:surface(of_system, side_u, side_y)
figure:panel{x = "u(k-1)", y = "y(k-1)"}:surface(of_model, side_u, side_y, {points_x = pl.vector(us), points_y = pl.vector(ys), points_z = (y + noise):slice(2, 300)})
save(figure, 6)
-- Contours of both, and the slope over the last output where u = 0: 1 - 0.5/cosh^2(y) of the system.
figure = pl.figure{title = "Contours of system (left) and process (middle), and slope over y(k-1) at u = 0 (right)", columns = 3}
figure:panel{x = "u(k-1)", y = "y(k-1)"}:contour(of_system, side_u, side_y)
figure:panel{x = "u(k-1)", y = "y(k-1)"}:contour(of_model, side_u, side_y)
local middles, slopes, steepest = pl.zeros(32), pl.zeros(32), 0
for j = 1, 32 do
  middles[j] = (side_y[j] + side_y[j + 1]) / 2
  slopes[j] = (of_model(j + 1, 17) - of_model(j, 17)) / (side_y[j + 1] - side_y[j])
end
local exact = 0.5 + 0.5 * pl.tanh(middles) ^ 2
local panel = figure:panel{x = "y(k-1)", y = "slope"}
panel:line(middles, exact, {color = "grey", label = "system"})
panel:line(middles, slopes, {color = "blue", label = "process"})
save(figure, 7)
for j = 1, 32 do
  if math.abs(middles[j]) < 0.8 then steepest = math.max(steepest, math.abs(slopes[j] - exact[j])) end
end
print("the slope where the data lie is right to 0.15: " .. (steepest < 0.15 and "yes" or ("no, %.2f off"):format(steepest)))
-- The deviation at a state: a record of one lag and a step has it after its first sample.
local pairs_of = {}
for j = 1, 33 do
  for i = 1, 33 do pairs_of[#pairs_of + 1] = identify.data{u = pl.vector{side_u[i], 0}, y = pl.vector{side_y[j], 0}, Ts = 0.5} end
end
local all_pairs = pairs_of[1]
for first = 2, #pairs_of, 200 do
  all_pairs = identify.join(all_pairs, table.unpack(pairs_of, first, math.min(first + 199, #pairs_of)))
end
local _, spread = process:uncertain(all_pairs, {propagation = "naive"})
local deviations = grid(function(i, j) return math.sqrt(spread[2 * ((j - 1) * 33 + i)]) end)
figure = pl.figure{title = "How unsure the process is of the next output (left), and where its data lie (right)", columns = 2}
figure:panel{x = "u(k-1)", y = "y(k-1)"}:surface(deviations, side_u, side_y)
figure:panel{x = {label = "u(k-1)", limits = {-1.6, 1.6}}, y = {label = "y(k-1)", limits = {-1.7, 1.7}}}:markers(pl.vector(us), pl.vector(ys), {color = "grey", size = 3})
save(figure, 11)
print("less sure beyond the inputs of the data: " .. yes(deviations(17, 33) > deviations(17, 17)))
