-- How well do a network and a Gaussian process follow the neutralisation of an acid, and does the process know where it does not?
--
-- Figures 3.22 to 3.30 and 7.12 to 7.16 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related
-- Methods (2023): the pH of the plant (3.11), (3.12) every 25 s; NARX models with four lags of pH and of the base's flow, a
-- network of 10 tanh neurons, and a Gaussian process of 200 points with noise of 0.02 on its targets.
-- plantloop script scripts/book/ph_process.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local function save(figure, number) figure:save(("out/figure_%s.%s"):format(number, format)) end
local function yes(holds) return holds and "yes" or "no" end
local Ts = 25

-- The plant of diagrams/parts/ph_neutralisation.yaml under a flow of base that is held between samples: the measured pH at
-- the samples, from rest.
local function measured(u)
  local times, values, n = {0}, {u[1]}, #u
  for k = 2, n do
    if u[k] ~= u[k - 1] then
      for _, value in ipairs{u[k - 1], u[k]} do times[#times + 1], values[#values + 1] = (k - 1) * Ts, value end
    end
  end
  local function list(numbers)
    local texts = {}
    for i, x in ipairs(numbers) do texts[i] = ("%.17g"):format(x) end
    return "[" .. table.concat(texts, ", ") .. "]"
  end
  local run = pl.diagram(([[
plantloop: 1
import: [../../diagrams/parts/ph_neutralisation.yaml]
blocks:
  base: {type: signal_builder, times: %s, values: %s}
  plant: {type: ph_neutralisation, in: base}
simulation: {stop: %d, rtol: 1e-6, atol: 1e-9, output_interval: %d}
record: [plant.sensor]
]]):format(list(times), list(values), (n - 1) * Ts, Ts)):run()
  local y, at = pl.zeros(n), pl.linspace(0, (n - 1) * Ts, n)
  for k = 1, n do y[k] = run:at("plant.sensor", at[k]) end
  return y
end
local function record(samples, hold, lower, upper, seed)
  local u = identify.staircase{samples = samples, hold = hold, lower = lower, upper = upper, seed = seed}
  u[1] = 15.6
  return identify.data{u = u, y = measured(u), Ts = Ts, inputs = {"q3"}, outputs = {"pH"}}
end
-- Pulses of growing height up and down from the rest: answers upwards and downwards differ, and do not grow alike.
local pulses = pl.ones(260) * 15.6
for i, height in ipairs{0.5, 1, 1.5, 2, 2.5} do
  for k = 1, 20 do
    pulses[50 * (i - 1) + 5 + k], pulses[50 * (i - 1) + 30 + k] = 15.6 + height, 15.6 - height
  end
end
local shown = identify.data{u = pulses, y = measured(pulses), Ts = Ts, inputs = {"q3"}, outputs = {"pH"}}
local figure = pl.figure{title = "Pulses of growing height", x = "time t [s]", y = "base q_3 [ml/s]"}
figure:stairs(shown.time, shown.u, {color = "grey"})
save(figure, "3_22")
figure = pl.figure{title = "Equal steps up and down are not answered alike", x = "time t [s]", y = "pH"}
figure:line(shown.time, shown.y, {color = "blue"})
save(figure, "3_23")
local up, down = shown.y[25] - shown.y[1], shown.y[1] - shown.y[50]
print(("steps of 0.5 ml/s: up %.3f pH, down %.3f pH"):format(up, down))

local train = record(1200, {2, 12}, 12, 18.5, 1)
local slow = record(500, {8, 30}, 13, 17.5, 2)     -- validation A: other holds, inside of the data
local lively = record(400, {2, 12}, 12, 18.5, 3)   -- validation B: as the identification, to its edges
figure = pl.figure{title = "Identification (left) and validation (right)", columns = 2}
for row = 1, 2 do
  for i, data in ipairs{train, slow} do
    local panel = figure:panel{x = {label = "time t [s]", limits = {0, data.samples * Ts}}, y = row == 1 and "pH" or "base q_3 [ml/s]",
                               height = row == 1 and 1 or 0.5}
    if row == 1 then panel:line(data.time, data.y, {color = "blue"}) else panel:stairs(data.time, data.u, {color = "grey"}) end
  end
end
save(figure, "3_24")
for number, data in pairs{["3_25"] = train, ["3_26"] = slow} do
  figure = pl.figure{title = number == "3_25" and "Flows of base to identify with" or "Flows of base to validate with", x = "base q_3 [ml/s]", y = "samples"}
  figure:histogram(data.u, {bins = 20})
  save(figure, number)
end

-- The network, and what is superfluous in it.
local regressors = "pH(k-1..4), q3(k-1..4)"
local function one_step(model, data) return identify.metrics(data.y, model:predict(data, 1), {skip = 4}).RMSE end
local function free_run(model, data) return identify.metrics(data.y, model:simulate(data), {skip = 4}).RMSE end
local linear = identify.arx(train, {na = 4, nb = 4, remove_means = true})
local network = identify.mlp(train, {regressors = regressors, hidden = 10, starts = 8, iterations = 300, decay = 1e-4, seed = 1})
local pruned = network:prune(train, {test = slow, decay = 1e-4, least = 85})
print(("linear, free run: %.3f and %.3f pH"):format(free_run(linear, slow), free_run(linear, lively)))
print(("network, one step: %.4f pH; free run: %.3f and %.3f pH"):format(one_step(network, slow), free_run(network, slow), free_run(network, lively)))

figure = pl.figure{title = "The network after pruning"}
figure:network(pruned.layers, {weights = pruned.weights, outputs = {"pH(k)"},
                               inputs = {"pH(k-1)", "pH(k-2)", "pH(k-3)", "pH(k-4)", "q_3(k-1)", "q_3(k-2)", "q_3(k-3)", "q_3(k-4)"}})
save(figure, "3_27")
local function response(number, title, data, mean, deviation)
  figure = pl.figure{title = title, x = "time t [s]"}
  local panel = figure:panel{y = "pH"}
  if deviation then panel:band(data.time, mean - 2 * deviation, mean + 2 * deviation, {color = "blue", label = "two standard deviations"}) end
  panel:line(data.time, data.y, {color = "grey", label = "system"})
  panel:line(data.time, mean, {color = "blue", label = "model in free run"})
  figure:panel{y = "error", height = 0.5}:line(data.time, data.y - mean, {color = "vermillion"})
  save(figure, number)
end
local e = (slow.y - pruned:simulate(slow)):slice(5, slow.samples)
figure = pl.figure{title = "Error of the free run with itself"}
figure:correlation(e)
save(figure, "3_28")
figure = pl.figure{title = "Error of the free run with the input"}
figure:correlation(e, {with = slow.u:slice(5, slow.samples)})
save(figure, "3_29")
response("3_30", "The network in free run over the validation", slow, pruned:simulate(slow))

-- The Gaussian process: every sixth sample with its lags, targets with noise of 0.02.
local noise, rows, all = identify.white_noise{samples = train.samples, deviation = 0.02, seed = 4}, {}, nil
for k = 5, train.samples, 6 do
  local y = train.y:slice(k - 4, k):copy()
  y[5] = y[5] + noise[k]
  rows[#rows + 1] = identify.data{u = train.u:slice(k - 4, k), y = y, Ts = Ts, inputs = {"q3"}, outputs = {"pH"}}
end
all = identify.join(table.unpack(rows))
local process = identify.gaussian_process(all, {regressors = regressors, starts = 3, iterations = 200, seed = 2})
local function judge(data)
  local mean, variance = process:uncertain(data, {propagation = "moment_matching"})
  local measures = identify.metrics(data.y, mean, {skip = 4, variance = variance + 0.0004})
  local naive_mean, naive = process:uncertain(data, {propagation = "naive"})
  return mean, (variance + 0.0004) ^ 0.5, measures, identify.metrics(data.y, naive_mean, {skip = 4, variance = naive + 0.0004})
end
local mean_b, deviation_b, b, b_naive = judge(lively)
local mean_a, deviation_a, a, a_naive = judge(slow)
print(("process, edge of the data: AE %.3f, SE %.4f, LD %.2f; naive LD %.2f"):format(b.AE, b.SE, b.LD, b_naive.LD))
print(("process, inside:           AE %.3f, SE %.4f, LD %.2f; naive LD %.2f"):format(a.AE, a.SE, a.LD, a_naive.LD))
print(("network of 10 neurons: one step below 0.01 pH: %s; free run below 0.03 and 0.08 pH: %s; five times better than linear: %s"):format(
  yes(one_step(network, slow) < 0.01), yes(free_run(network, slow) < 0.03 and free_run(network, lively) < 0.08),
  yes(5 * free_run(network, slow) < free_run(linear, slow) and 5 * free_run(network, lively) < free_run(linear, lively))))
local function test_error(removed) return tonumber(pruned.report.tried[removed + 1]:match("test ([%d.e-]+)")) end
print(("five of its weights are superfluous, the validation changes by less than 10 %%: %s"):format(yes(math.abs(test_error(5) / test_error(0) - 1) < 0.1)))
print(("process: AE below 0.15, SE below 0.05 inside: %s; less certain at the edge: %s"):format(
  yes(a.AE < 0.15 and a.SE < 0.05), yes(pl.mean(deviation_b) > pl.mean(deviation_a))))
response("7_12", "Validation at the edge of the data: mean of the process", lively, mean_b)
figure = pl.figure{title = "Error of the free run with itself, at the edge"}
figure:correlation((lively.y - mean_b):slice(5, lively.samples))
save(figure, "7_13")
response("7_14", "Validation at the edge of the data: where the process is less certain", lively, mean_b, deviation_b)
response("7_15", "Validation inside of the data", slow, mean_a, deviation_a)
figure = pl.figure{title = "Error of the free run with itself, inside"}
figure:correlation((slow.y - mean_a):slice(5, slow.samples))
save(figure, "7_16")
