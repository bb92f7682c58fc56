-- How many neurons, or how many radial functions, does a network need to follow a known function?
--
-- Figures 1.8 to 1.13, 1.18 to 1.21 and 1.23 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and
-- Related Methods (2023): equations (1.6), (1.7), (1.10) and (1.13). The book prints no domains: x in [0, 1] for (1.6), a
-- square from -1 to 1 for (1.7) and (1.10), inputs between -1 and 1 for (1.13).
-- Surfaces are coloured beside the mesh of the function that they are to follow.
-- plantloop script scripts/book/static_networks.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local function save(figure, number) figure:save(("out/figure_1_%s.%s"):format(number, format)) end
local function count(n, what) return ("%d %s%s"):format(n, what, n == 1 and "" or "s") end
local function rmse(model, data) return identify.metrics(data.y, model:simulate(data)).RMSE end

-- (1.6), a curve with four bends: sigmoid neurons, Levenberg-Marquardt from 15 starts.
local x = pl.linspace(0, 1, 101)
local y = 30 * (100 * (x - 0.6) ^ 2 * (x - 0.1) * (x - 0.8) - 5 * pl.exp(-5 * x) + 0.9 * pl.sin(20 * x + pl.pi / 4))
local curve = identify.data{u = x, y = y, Ts = 1, inputs = {"x"}, outputs = {"f"}}
for _, size in ipairs{{1, "8"}, {2, "9"}, {3}, {5, "10"}} do
  local neurons, number = size[1], size[2]
  local network = identify.mlp(curve, {regressors = "x(k)", hidden = neurons, activation = "sigmoid", starts = 15, spread = 3, seed = 1})
  print(("equation (1.6), %s: RMSE %.2f"):format(count(neurons, "neuron"), rmse(network, curve)))
  if number then
    local figure = pl.figure{title = "A curve and a network of " .. count(neurons, "sigmoid neuron"), x = "x", y = "f(x)"}
    figure:line(x, y, {color = "grey", label = "equation (1.6)"})
    figure:line(x, network:simulate(curve), {color = "blue", label = "network"})
    save(figure, number)
  end
end

-- A function of two variables on a grid, as a data set and as a matrix.
local function grid(f)
  local axis, u, values = pl.linspace(-1, 1, 21), {}, {}
  for i = 1, 21 do
    for j = 1, 21 do
      u[#u + 1] = {axis[i], axis[j]}
      values[#values + 1] = f(axis[i], axis[j])
    end
  end
  return axis, identify.data{u = pl.matrix(u), y = pl.vector(values), Ts = 1, inputs = {"a", "b"}, outputs = {"z"}}
end
-- The matrix of f(i, j), n x n.
local function matrix_of(n, f)
  local rows = {}
  for i = 1, n do
    rows[i] = {}
    for j = 1, n do rows[i][j] = f(i, j) end
  end
  return pl.matrix(rows)
end
local function as_surface(z) return matrix_of(21, function(i, j) return z[(i - 1) * 21 + j] end) end
local function compare(title, network, data, axis, number)
  local figure = pl.figure{title = title, x = "x", y = "y"}
  figure:surface(as_surface(data.y), axis, axis, {wireframe = true})
  figure:surface(as_surface(network:simulate(data)), axis, axis)
  save(figure, number)
end

-- (1.7), a surface: one, two and five neurons.
local axis, hills = grid(function(a, b) return a * math.cos(2 * a) + b * math.sin(2 * b) - 0.75 end)
for _, size in ipairs{{1, "11"}, {2, "12"}, {5, "13"}} do
  local network = identify.mlp(hills, {regressors = "a(k), b(k)", hidden = size[1], activation = "sigmoid", starts = 12, spread = 3, iterations = 300, seed = 2})
  print(("equation (1.7), %s: RMSE %.4f"):format(count(size[1], "neuron"), rmse(network, hills)))
  compare("Network of " .. count(size[1], "sigmoid neuron"), network, hills, axis, size[2])
end

-- (1.10), a surface with folds: Gaussian functions whose centres orthogonal least squares takes from the grid, one by one.
local _, folds = grid(function(a, b) return math.sin(0.4 * a ^ 3 - 1.6 * b ^ 2 + 0.5) end)
for _, size in ipairs{{3, "18"}, {5, "19"}, {11, "20"}, {31, "21"}} do
  local network = identify.rbf_network(folds, {regressors = "a(k), b(k)", functions = size[1], width = 0.1, constant = false, ridge = 0})
  print(("equation (1.10), %d functions: nRMSE %.3f"):format(size[1], rmse(network, folds) / pl.std(folds.y)))
  compare(("%d radial functions"):format(size[1]), network, folds, axis, size[2])
end

-- (1.13), a dynamic system: 20 Gaussian functions in the box of the data. Outside of it they decay to their constant.
local n = 2207
local u = identify.staircase{samples = n, hold = 3, lower = -1, upper = 1, seed = 4}
local out = pl.zeros(n)
for k = 2, n do
  local e = math.exp(2 * out[k - 1])
  out[k] = 0.2 * (e - 1) / (e + 1) + math.sin(u[k - 1])
end
local record = identify.data{u = u, y = out, Ts = 1}
local network = identify.rbf_network(record, {regressors = "y(k-1), u(k-1)", centres = "box", functions = 20, width = 0.3, ridge = 1e-8, seed = 3})
local free = identify.metrics(record.y, network:simulate(record), {skip = 1}).RMSE
print(("equation (1.13), 20 functions: free run RMSE %.4f, %s"):format(free, free < 0.05 and "below 0.05" or "NOT below 0.05"))
local side = pl.linspace(-2, 2, 31)
local system = matrix_of(31, function(i, j)
  local e = math.exp(2 * side[i])
  return 0.2 * (e - 1) / (e + 1) + math.sin(side[j])
end)
-- The network at any point: the second of two samples, one step ahead; all pairs below each other.
local inputs, pasts = {}, {}
for i = 1, 31 do
  for j = 1, 31 do
    pasts[#pasts + 1], pasts[#pasts + 2] = side[i], 0
    inputs[#inputs + 1], inputs[#inputs + 2] = side[j], 0
  end
end
local answers = network:predict(identify.data{u = pl.vector(inputs), y = pl.vector(pasts), Ts = 1}, 1)
local of_network = matrix_of(31, function(i, j) return answers[2 * ((i - 1) * 31 + j)] end)
local figure = pl.figure{title = "The system (1.13) and a network that has seen its middle", columns = 2}
figure:panel{x = "u(k)", y = "y(k)"}:surface(system, side, side)
figure:panel{x = "u(k)", y = "y(k)"}:surface(of_network, side, side)
save(figure, "23")
