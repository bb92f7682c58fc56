-- How do local models make up a nonlinear system, and what do they need to know to be chosen?
--
-- Figures 5.6, 5.7 and 5.10 to 5.13 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
-- (2023), on the system (3.9): affine models on a grid, scheduled by input and output, or by the input alone.
-- plantloop script scripts/book/local_models.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local function save(figure, number) figure:save(("out/figure_5_%s.%s"):format(number, format)) end

local function record(samples, hold, seed)
  local u = identify.staircase{samples = samples, hold = hold, lower = -1.2, upper = 1.2, seed = seed}
  local noise, y = identify.white_noise{samples = samples, deviation = 0.01, seed = seed + 1000}, pl.zeros(samples)
  for k = 2, samples do
    local e = math.exp(2 * (y[k - 1] + u[k - 1] ^ 3))
    y[k] = y[k - 1] - 0.5 * (e - 1) / (e + 1) + noise[k]
  end
  return identify.data{u = u, y = y, Ts = 0.5}
end
local data, fresh = record(600, 4, 21), record(300, 6, 22)

-- The curve of equilibria, y = -u^3, from five local models on an even grid: its tangents, blended (figure 5.6), and closer
-- (figure 5.7). A tangent is drawn as far as its cell goes.
local function centre(i) return -1.2 + 0.48 * (i - 0.5) end
local function tangent(i, u) return -centre(i) ^ 3 - 3 * centre(i) ^ 2 * (u - centre(i)) end
local function blend(u)
  local w, sum, y = {}, pl.zeros(#u), pl.zeros(#u)
  for i = 1, 5 do
    w[i] = pl.exp(-0.5 * ((u - centre(i)) / (0.48 / 3)) ^ 2)
    sum = sum + w[i]
  end
  local rows = {}
  for k = 1, #u do rows[k] = {} end
  for i = 1, 5 do
    y = y + w[i] / sum * tangent(i, u)
    for k = 1, #u do rows[k][i] = w[i][k] / sum[k] end
  end
  return y, pl.matrix(rows)
end
for number, range in pairs{[6] = {-1.2, 1.2, "Five local models on an even grid"}, [7] = {-1.2, -0.2, "The same closer: from one tangent to the next"}} do
  local u = pl.linspace(range[1], range[2], 241)
  local blended, weights = blend(u)
  local figure = pl.figure{title = range[3], x = {label = "scheduling variable u", limits = {range[1], range[2]}}}
  local top = figure:panel{y = "output at rest y"}
  for i = 1, 5 do
    local own = pl.linspace(centre(i) - 0.24, centre(i) + 0.24, 2)
    if own[2] > range[1] and own[1] < range[2] then top:line(own, tangent(i, own), {color = "vermillion", width = 1.2, label = i == 2 and "local models" or ""}) end
  end
  top:line(u, -u ^ 3, {color = "grey", label = "system"})
  top:line(u, blended, {color = "blue", style = "dashed", label = "blended"})
  figure:panel{y = "weight", height = 0.6}:weighting(u, weights)
  save(figure, number)
end
local u_all = pl.linspace(-1.2, 1.2, 241)
local off = pl.max(pl.abs(blend(u_all) + u_all ^ 3))
-- Farthest off at the edges, where the last tangent is 3*0.96*0.24^2 + 0.24^3 off.
print(("five blended tangents follow the points of rest to 0.180: %s"):format(math.abs(off - 0.1797) < 5e-4 and "yes" or off))

-- From one point of rest to another and back (figure 5.10): where the state is, and which of five models, scheduled by the
-- output, counts most. Away from the curve of equilibria there are hardly any samples.
do
  local n = 120
  local u, y, t = pl.zeros(n), pl.zeros(n), pl.range(0, (n - 0.5) * 0.5, 0.5)
  for k = 1, n do
    u[k] = (k > 30 and k <= 60) and 1.1 or (k > 90 and 0.75 or -1.1)
    if k == 1 then y[k] = -u[k] ^ 3 else y[k] = y[k - 1] - 0.5 * pl.tanh(y[k - 1] + u[k - 1] ^ 3) end
  end
  local curve, away, switches, active = pl.linspace(-1.2, 1.2, 121), 0, 0, pl.zeros(n)
  for k = 1, n do
    active[k] = math.max(1, math.min(5, math.floor((y[k] + 1.7) / 0.68) + 1))
    if k > 1 and active[k] ~= active[k - 1] then switches = switches + 1 end
    if math.abs(y[k] + u[k] ^ 3) > 0.1 then away = away + 1 end
  end
  local figure = pl.figure{title = "Switching from one local model to another", columns = 2}
  local left = figure:panel{x = {label = "u", limits = {-1.3, 1.3}}, y = {label = "y", limits = {-1.7, 1.7}}}
  for i = 1, 4 do left:line(pl.vector{-1.3, 1.3}, pl.vector{-1.7 + 0.68 * i, -1.7 + 0.68 * i}, {color = "sky", width = 0.5, label = i == 1 and "borders of the models" or ""}) end
  left:line(curve, -curve ^ 3, {color = "grey", label = "points of rest"})
  left:line(u, y, {color = "blue", style = "line_points", label = "samples"})
  figure:panel{x = {label = "time t [s]", limits = {0, 60}}, y = {label = "model that counts most", limits = {0.5, 5.5}}}:stairs(t, active, {color = "blue"})
  save(figure, 10)
  print(("three samples of four lie at rest: %s; the model changes %d times"):format(away < n / 4 and "yes" or ("no, %d of %d do not"):format(away, n), switches))
end

local function errors(model)
  return identify.metrics(data.y, model:predict(data, 1), {skip = 1}).RMSE, identify.metrics(fresh.y, model:predict(fresh, 1), {skip = 1}).RMSE,
         identify.metrics(fresh.y, model:simulate(fresh), {skip = 1}).RMSE
end
-- Cells that the data hardly visit need the ridge: without it global estimation gives them any parameters at all.
local function fit(cells, width, estimation, scheduling)
  return identify.local_models(data, {regressors = "y(k-1), u(k-1)", cells = cells, width = width, estimation = estimation, scheduling = scheduling, ridge = 1e-4})
end
local candidates = {
  {"3 x 3, width 1/3, global", fit(3, 1 / 3, "global")},
  {"5 x 5, width 1/3, global", fit(5, 1 / 3, "global")},
  {"5 x 5, width 1/3, local", fit(5, 1 / 3, "local")},
  {"5 x 5, width 1/2, global", fit(5, 1 / 2, "global")},
  {"5 x 5, width 1/2, local", fit(5, 1 / 2, "local")},
  {"u alone, 5 cells, width 1/3, local", fit(5, 1 / 3, "local", 2)},
}
local found = {}
print(("%-38s %10s %10s %10s"):format("grid and estimation", "fit", "one step", "free run"))
local function tell(what, model)
  local fitted, step, run = errors(model)
  print(("%-38s %10.4f %10.4f %10.4f"):format(what, fitted, step, run))
  return {fitted, step, run}
end
for i, c in ipairs(candidates) do found[i] = tell(c[1], c[2]) end
tell("a tree of 10 models", identify.local_models(data, {regressors = "y(k-1), u(k-1)", models = 10}))
local function verdict(holds) return holds and "yes" or "no" end
print("global estimation fits better than local: " .. verdict(found[2][1] < found[3][1] and found[4][1] < found[5][1]))
print("the input alone schedules worse: " .. verdict(found[6][3] > 1.5 * found[3][3]))

-- What a scheduling vector means (figure 5.11): by both variables a model counts in its cell, by the input alone in a strip,
-- however far from rest the state is.
local figure = pl.figure{title = "Where a model counts: scheduled by u and y (left), by u alone (right)", columns = 2}
for _, full in ipairs{true, false} do
  local panel = figure:panel{x = {label = "u(k-1)", limits = {-1.2, 1.2}}, y = {label = "y(k-1)", limits = {-1.7, 1.7}}}
  local low, high = full and -0.34 or -1.7, full and 0.34 or 1.7
  panel:region(pl.vector{-0.24, 0.24, 0.24, -0.24}, pl.vector{low, low, high, high}, {color = "sky", opacity = 0.6, label = "one model"})
  panel:markers(data.u:slice(1, 599), data.y:slice(1, 599), {marker = "dot", color = "grey", size = 2.5, label = "data"})
  for i = 1, 4 do
    panel:line(pl.vector{-1.2 + 0.48 * i, -1.2 + 0.48 * i}, pl.vector{-1.7, 1.7}, {color = "blue", width = 0.6})
    if full then panel:line(pl.vector{-1.2, 1.2}, pl.vector{-1.7 + 0.68 * i, -1.7 + 0.68 * i}, {color = "blue", width = 0.6}) end
  end
  panel:line(u_all, -u_all ^ 3, {color = "vermillion", label = "points of rest"})
end
save(figure, 11)

-- The system as a surface (figure 5.12), and two networks (figure 5.13). A model's answer at any point: the second of two
-- samples, one step ahead; all pairs below each other.
local side_u, side_y = pl.linspace(-1.2, 1.2, 31), pl.linspace(-1.5, 1.5, 31)
local function matrix_of(value)
  local rows = {}
  for j = 1, 31 do
    rows[j] = {}
    for i = 1, 31 do rows[j][i] = value(i, j) end
  end
  return pl.matrix(rows)
end
local inputs, pasts = {}, {}
for j = 1, 31 do
  for i = 1, 31 do
    inputs[#inputs + 1], inputs[#inputs + 2] = side_u[i], 0
    pasts[#pasts + 1], pasts[#pasts + 2] = side_y[j], 0
  end
end
local plane = identify.data{u = pl.vector(inputs), y = pl.vector(pasts), Ts = 0.5}
local function answers_of(model)
  local answers = model:predict(plane, 1)
  return matrix_of(function(i, j) return answers[2 * ((j - 1) * 31 + i)] end)
end
local of_system = matrix_of(function(i, j)
  local e = math.exp(2 * (side_y[j] + side_u[i] ^ 3))
  return side_y[j] - 0.5 * (e - 1) / (e + 1)
end)
figure = pl.figure{title = "The system", x = "u(k-1)", y = "y(k-1)"}
figure:surface(of_system, side_u, side_y)
save(figure, 12)
local complete, reduced = answers_of(candidates[3][2]), answers_of(candidates[6][2])
figure = pl.figure{title = "Local models scheduled by u alone (left), and by u and y (right)", columns = 2}
figure:panel{x = "u(k-1)", y = "y(k-1)"}:surface(reduced, side_u, side_y)
figure:panel{x = "u(k-1)", y = "y(k-1)"}:surface(complete, side_u, side_y)
save(figure, 13)
-- Near the data and all over the plane, away from points of rest too.
local function off_system(surface)
  local sum = 0
  for j = 1, 31 do
    for i = 1, 31 do sum = sum + (surface(j, i) - of_system(j, i)) ^ 2 end
  end
  return math.sqrt(sum) / 31
end
print(("over the whole plane the complete vector is nearer to the system: %s"):format(verdict(off_system(complete) < off_system(reduced))))

-- The system in free run and two networks.
local t = fresh.time
figure = pl.figure{title = "Local models in free run", x = {label = "time t [s]", limits = {0, 150}}}
local top, bottom = figure:panel{y = "y"}, figure:panel{y = "error", height = 0.6}
top:line(t, fresh.y, {color = "grey", label = "system"})
for _, c in ipairs{{candidates[3][2], "blue", "by u and y"}, {candidates[6][2], "vermillion", "by u alone"}} do
  local run = c[1]:simulate(fresh)
  top:line(t, run, {color = c[2], label = c[3]})
  bottom:line(t, fresh.y - run, {color = c[2]})
end
figure:save("out/local_models_free_run." .. format)
