-- What do neurons, radial functions, regions of local models and the checks of a model look like?
--
-- Figures 1.7, 1.15 to 1.17, 3.2 to 3.7, 5.8 and 5.9 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and
-- Related Methods (2023), which show ideas without numbers: here of functions (1.5), (1.9) and (1.10) and of system (3.9) with
-- equation noise of 0.02. Figure 1.22 is diagrams/book/network_simulation.yaml.
-- plantloop script scripts/book/basics.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local function save(figure, number) figure:save(("out/figure_%s.%s"):format(number, format)) end
local function yes(holds) return holds and "yes" or "no" end

-- Activations: the sigmoid is a tanh of half the sum, moved (figure 1.7).
local s = pl.linspace(-6, 6, 241)
local sigmoid = 1 / (1 + pl.exp(-s))
local figure = pl.figure{title = "Activations of neurons", x = "weighted sum s", y = "activation"}
figure:line(s, sigmoid, {color = "blue", label = "sigmoid, a = 1"})
figure:line(s, s / 6, {color = "vermillion", label = "linear, s/6"})
save(figure, "1_7")
print("the sigmoid is (1 + tanh(s/2))/2: " .. yes(pl.max(pl.abs(sigmoid - (1 + pl.tanh(s / 2)) / 2)) < 1e-15))

-- Radial functions of two widths (1.15).
local r = pl.linspace(-3, 3, 241)
figure = pl.figure{title = "Gaussian radial functions", x = "distance r from the centre", y = "exp(-r^2/ρ^2)"}
for _, width in ipairs{{0.5, "sky"}, {1, "blue"}, {2, "vermillion"}} do
  figure:line(r, pl.exp(-(r / width[1]) ^ 2), {color = width[2], label = ("ρ = %g"):format(width[1])})
end
save(figure, "1_15")

-- Where orthogonal least squares puts centres for (1.10), in what order (1.16).
local axis, candidates, targets = pl.linspace(-1, 1, 21), {}, {}
for _, x in ipairs(axis:table()) do
  for _, y in ipairs(axis:table()) do
    candidates[#candidates + 1] = {x, y}
    targets[#targets + 1] = math.sin(0.4 * x ^ 3 - 1.6 * y ^ 2 + 0.5)
  end
end
local chosen = {}
local rest = pl.vector(targets)
-- One function for each point of the grid; each next one takes most of what is left (modified Gram-Schmidt).
local columns = {}
for i, c in ipairs(candidates) do
  local p = {}
  for j, x in ipairs(candidates) do p[j] = math.exp(-0.5 * ((x[1] - c[1]) ^ 2 + (x[2] - c[2]) ^ 2) / 0.2 ^ 2) end
  columns[i] = pl.vector(p)
end
for _ = 1, 20 do
  local best, most = nil, 0
  for i, w in ipairs(columns) do
    local length = pl.dot(w, w)
    local part = length > 1e-9 and pl.dot(w, rest) ^ 2 / length or 0
    if part > most then best, most = i, part end
  end
  local w = columns[best] / math.sqrt(pl.dot(columns[best], columns[best]))
  chosen[#chosen + 1] = candidates[best]
  rest = rest - w * pl.dot(w, rest)
  for i, column in ipairs(columns) do columns[i] = column - w * pl.dot(w, column) end
end
local first, second = {}, {}
for i, c in ipairs(chosen) do first[i], second[i] = c[1], c[2] end
figure = pl.figure{title = "Centres that orthogonal least squares chooses", x = {label = "x_1", limits = {-1.1, 1.1}}, y = {label = "x_2", limits = {-1.1, 1.1}}}
local ax, ay = {}, {}
for i, c in ipairs(candidates) do ax[i], ay[i] = c[1], c[2] end
figure:markers(pl.vector(ax), pl.vector(ay), {marker = "dot", color = "grey", size = 2, label = "data"})
figure:markers(pl.vector(first), pl.vector(second), {marker = "ring", color = "vermillion", label = "20 centres"})
save(figure, "1_16")
print(("20 functions leave %.0f %% of the deviation"):format(100 * pl.std(rest) / pl.std(pl.vector(targets))))

-- A curve as a sum of weighted functions (1.17): least squares of nine on an even grid.
local x = pl.linspace(0, 1, 121)
local curve = 0.5 + 0.4 * pl.sin(5 * x) + 0.3 * x ^ 2
local rows, functions = {}, {}
for i = 1, 9 do functions[i] = pl.exp(-0.5 * ((x - (i - 1) / 8) / 0.16) ^ 2) end
for k = 1, #x do
  rows[k] = {}
  for i = 1, 9 do rows[k][i] = functions[i][k] end
end
local weights = identify.least_squares(pl.matrix(rows), curve).theta
figure = pl.figure{title = "A curve as a sum of nine radial functions", x = "x", y = "y"}
local sum = pl.zeros(#x)
for i = 1, 9 do
  sum = sum + weights[i] * functions[i]
  figure:line(x, weights[i] * functions[i], {color = "grey", label = i == 1 and "weighted functions" or ""})
end
figure:line(x, curve, {color = "vermillion", label = "curve"})
figure:line(x, sum, {color = "blue", style = "dashed", label = "sum"})
save(figure, "1_17")
print("nine functions follow the curve to 3 %: " .. yes(pl.max(pl.abs(sum - curve)) < 0.03 * (pl.max(curve) - pl.min(curve))))

-- Data of system (3.9), a model of it, and the checks of chapter 3.
local function record(samples, hold, seed)
  local u = identify.staircase{samples = samples, hold = hold, lower = -1.2, upper = 1.2, seed = seed}
  local noise, y = identify.white_noise{samples = samples, deviation = 0.02, seed = seed + 1000}, pl.zeros(samples)
  for k = 2, samples do y[k] = y[k - 1] - 0.5 * pl.tanh(y[k - 1] + u[k - 1] ^ 3) + noise[k] end
  return identify.data{u = u, y = y, Ts = 0.5}
end
local train, fresh = record(500, 4, 13), record(300, 6, 14)
figure = pl.figure{title = "Where the data lie", x = "input u(k-1)", y = "output y(k-1)"}
figure:coverage(train.u, train.y, {test_x = fresh.u, test_y = fresh.y})
save(figure, "3_2")
figure = pl.figure{title = "How often the input takes its values", x = "input u", y = "samples"}
figure:histogram(train.u, {bins = 20})
save(figure, "3_3")
local network = identify.mlp(train, {regressors = "y(k-1), u(k-1)", hidden = 8, starts = 12, iterations = 300, decay = 1e-3, seed = 1})
local one_step, run = network:predict(fresh, 1), network:simulate(fresh)
figure = pl.figure{title = "One step ahead and in free run, on data that the model has not seen", x = {label = "time t [s]", limits = {0, 75}}}
local panel = figure:panel{y = "one step"}
panel:line(fresh.time, fresh.y, {color = "grey", label = "system"})
panel:line(fresh.time, one_step, {color = "blue", label = "model"})
panel = figure:panel{y = "free run"}
panel:line(fresh.time, fresh.y, {color = "grey"})
panel:line(fresh.time, run, {color = "blue"})
save(figure, "3_4")
local e, u = (fresh.y - one_step):slice(2, 300), fresh.u:slice(1, 299)
figure = pl.figure{title = "The residuals with themselves (left) and with the input (right)", columns = 2}
figure:panel{x = "lag [samples]", y = "autocorrelation"}:correlation(e)
figure:panel{x = "lag [samples]", y = "cross-correlation"}:correlation(e, {with = u})
save(figure, "3_5")
figure = pl.figure{title = "One-step errors, and as many of the same mean and deviation normally distributed", x = "error", y = "samples"}
figure:histogram(e, {bins = 20})
local at, bin = pl.linspace(pl.min(e), pl.max(e), 121), (pl.max(e) - pl.min(e)) / 20
figure:line(at, #e * bin * pl.exp(-0.5 * ((at - pl.mean(e)) / pl.std(e)) ^ 2) / (pl.std(e) * math.sqrt(2 * pl.pi)), {color = "vermillion", label = "normal"})
save(figure, "3_6")
print("one-step errors are as the noise, 0.02 within a quarter: " .. yes(math.abs(pl.std(e) / 0.02 - 1) < 0.25))
local pruned = network:prune(train, {test = fresh, decay = 1e-3, least = 16, iterations = 150})
figure = pl.figure{title = "The network after pruning"}
figure:network(pruned.layers, {weights = pruned.weights, inputs = {"y(k-1)", "u(k-1)"}, outputs = {"y(k)"}})
save(figure, "3_7")
local left = pruned.report.parameters
local function error_of(model) return identify.metrics(fresh.y, model:predict(fresh, 1), {skip = 1}).RMSE end
print("16 to 30 of 33 weights are left, with less error than all of them: " .. yes(left >= 16 and left <= 30 and error_of(pruned) < error_of(network)))

-- Regions of one behaviour each (5.8): where the slope over the output of (3.9), 1 - 0.5/cosh^2(y + u^3), is alike; and the same
-- plane in equal cells (5.9).
local side_u, side_y = pl.linspace(-1.2, 1.2, 61), pl.linspace(-1.7, 1.7, 61)
local slopes = {}
for j = 1, 61 do
  slopes[j] = {}
  for i = 1, 61 do slopes[j][i] = 0.5 + 0.5 * pl.tanh(side_y[j] + side_u[i] ^ 3) ^ 2 end
end
figure = pl.figure{title = "Regions of alike dynamics: the slope of the next output over the last one", x = "u(k-1)", y = "y(k-1)"}
figure:contour(pl.matrix(slopes), side_u, side_y, {filled = true})
save(figure, "5_8")
figure = pl.figure{title = "The same plane in equal cells, with the data", x = {label = "u(k-1)", limits = {-1.2, 1.2}}, y = {label = "y(k-1)", limits = {-1.7, 1.7}}}
figure:markers(train.u, train.y, {marker = "dot", color = "grey", size = 3})
for i = 1, 4 do
  local cut_u, cut_y = -1.2 + 0.48 * i, -1.7 + 0.68 * i
  figure:line(pl.vector{cut_u, cut_u}, pl.vector{-1.7, 1.7}, {color = "blue"})
  figure:line(pl.vector{-1.2, 1.2}, pl.vector{cut_y, cut_y}, {color = "blue"})
end
save(figure, "5_9")
