-- How do local models make up a nonlinear system, and what do they need to know to be chosen?
--
-- Figures 5.6, 5.7 and 5.11 to 5.13 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
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

-- The weights of five cells along one variable, normalised (figures 5.6 and 5.7): narrow and wide.
local function weights_of(width)
  local x, w, sum = pl.linspace(-1.2, 1.2, 241), {}, pl.zeros(241)
  for i = 1, 5 do
    w[i] = pl.exp(-0.5 * ((x - (-1.2 + 0.48 * (i - 0.5))) / (width * 0.48)) ^ 2)
    sum = sum + w[i]
  end
  local rows = {}
  for k = 1, 241 do
    rows[k] = {}
    for i = 1, 5 do rows[k][i] = w[i][k] / sum[k] end
  end
  return x, pl.matrix(rows)
end
for number, width in pairs{[6] = 1 / 3, [7] = 1 / 2} do
  local figure = pl.figure{title = ("Where five local models count: width %s of a cell"):format(number == 6 and "1/3" or "1/2"), x = "scheduling variable u", y = "weight"}
  figure:weighting(weights_of(width))
  save(figure, number)
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

-- The system in free run and two networks: scheduled fully (5.11) and by the input alone (5.12); the difference (5.13).
local t = fresh.time
for number, c in pairs{[11] = candidates[4], [12] = candidates[6]} do
  local figure = pl.figure{title = "Local models in free run: " .. c[1], x = "time t [s]", y = "y"}
  figure:line(t, fresh.y, {color = "grey", label = "system"})
  figure:line(t, c[2]:simulate(fresh), {color = "blue", label = "local models"})
  save(figure, number)
end
local figure = pl.figure{title = "Errors of the free run", x = "time t [s]", y = "error"}
figure:line(t, fresh.y - candidates[4][2]:simulate(fresh), {color = "blue", label = "scheduled by y and u"})
figure:line(t, fresh.y - candidates[6][2]:simulate(fresh), {color = "vermillion", label = "by u alone"})
save(figure, 13)
