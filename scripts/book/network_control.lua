-- What can a network do in a control loop? Models for the roles of figures 4.2 to 4.8, and the loops that they work in.
--
-- J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods (2023), section 4.1. Each network is
-- trained on records of simulated plants; the diagrams in diagrams/book that run them are drawn.
-- plantloop script scripts/book/network_control.lua [png|svg] [renew]
-- The models go to out/models; with `renew` they go to diagrams/book/models, when the working directory is the project's.
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local folder = arg[2] == "renew" and "diagrams/book/models" or "out/models"

local function list(numbers)
  local texts = {}
  for i = 1, #numbers do texts[i] = ("%.17g"):format(numbers[i]) end
  return "[" .. table.concat(texts, ", ") .. "]"
end
-- A signal that is held between samples, as parameters of a staircase.
local function staircase(u, Ts)
  local times, values = {0}, {u[1]}
  for k = 2, #u do
    if u[k] ~= u[k - 1] then times[#times + 1], values[#values + 1] = (k - 1) * Ts, u[k] end
  end
  return ("{type: staircase, times: %s, values: %s}"):format(list(times), list(values))
end
-- What a diagram's column is at the samples; the diagram has a %s for each signal.
local function sampled(run, column, Ts, samples)
  local y = pl.zeros(samples)
  for k = 1, samples do y[k] = run:at(column, (k - 1) * Ts) end
  return y
end

-- Writes a model file, and looks whether the network is the one that the diagrams run: on fresh data the two differ by less than
-- 3 % of what the signal varies by.
local all_as_stored = true
local function keep(name, model, data)
  model:save(("%s/%s.yaml"):format(folder, name))
  local stored = identify.load(pl.project .. "/diagrams/book/models/" .. name .. ".yaml")
  local difference = pl.abs(stored:predict(data, 1) - model:predict(data, 1))
  difference = pl.where(pl.less(difference, 1e9), difference, 0)   -- the first samples have no past
  local mean = pl.mean(data.y)
  if pl.mean(difference ^ 2) > 0.03 ^ 2 * pl.mean((data.y - mean) ^ 2) then
    all_as_stored = false
    print(("%s is not the stored network: up to %g apart"):format(name, pl.max(difference)))
  end
end

-- The conical tank of diagrams/parts under a pump that is held between samples of 5 s.
local Ts = 5
local function tank(samples, hold, seed)
  local u = identify.staircase{samples = samples, hold = hold, lower = 0.3, upper = 1.2, seed = seed}
  local run = pl.diagram(([[
plantloop: 1
import: [../../diagrams/parts/conical_tank.yaml]
blocks:
  u: %s
  tank: {type: conical_tank, in: u}
simulation: {stop: %d, rtol: 1e-9, output_interval: 5}
record: [tank.h]
]]):format(staircase(u, Ts), samples * Ts)):run()
  return u, sampled(run, "tank.h", Ts, samples)
end
local u, h = tank(1500, {2, 20}, 1)
local u_fresh, h_fresh = tank(500, {3, 30}, 2)

-- A model of the tank, for figures 4.4, 4.6 and internal model control.
local forward = identify.data{u = u, y = h, Ts = Ts, inputs = {"u"}, outputs = {"h"}}
local forward_fresh = identify.data{u = u_fresh, y = h_fresh, Ts = Ts, inputs = {"u"}, outputs = {"h"}}
local model = identify.mlp(forward, {regressors = "h(k-1), u(k-1)", hidden = 8, starts = 3, iterations = 400, seed = 1})
local free_run = identify.metrics(h_fresh, model:simulate(forward_fresh)).RMSE
keep("tank_mlp", model, forward_fresh)

-- Its inverse, from the same open-loop record: which command led from one level to the next (figure 4.8).
local function columns(...)
  local rows, signals = {}, {...}
  for k = 1, #signals[1] do
    rows[k] = {}
    for i, s in ipairs(signals) do rows[k][i] = s[k] end
  end
  return pl.matrix(rows)
end
local function backwards(v, g)
  local n = #v
  return identify.data{u = columns(g:slice(2, n), g:slice(1, n - 1)), y = v:slice(1, n - 1), Ts = Ts, inputs = {"after", "before"}, outputs = {"u"}}
end
local inverse = identify.mlp(backwards(u, h), {regressors = "after(k), before(k)", hidden = 10, starts = 3, iterations = 400, seed = 1})
local inverse_fresh = backwards(u_fresh, h_fresh)
local inverse_error = identify.metrics(inverse_fresh.y, inverse:predict(inverse_fresh, 1)).RMSE
keep("tank_inverse_mlp", inverse, inverse_fresh)

-- What the linear part of the pendulum's equation leaves over, theta'' + Q theta' - b F, from an accelerometer's record: the unknown
-- part of figures 4.2 and 4.3.
local function swing(samples, seed)
  local force = identify.staircase{samples = samples, hold = {10, 40}, lower = -40, upper = 40, seed = seed}
  local run = pl.diagram(([[
plantloop: 1
import: [../../diagrams/parts/pendulum.yaml]
blocks:
  force: %s
  plant: {type: pendulum, in: force}
  acceleration: 1.21*force - 29.46*plant.omega - 29.46*sin(plant.theta)
simulation: {stop: %g, rtol: 1e-9, output_interval: 0.05}
record: [force, plant.theta, plant.omega, acceleration]
]]):format(staircase(force, 0.05), samples * 0.05)):run()
  local theta = sampled(run, "plant.theta", 0.05, samples)
  local rest = sampled(run, "acceleration", 0.05, samples) + 29.46 * sampled(run, "plant.omega", 0.05, samples)
             - 1.21 * sampled(run, "force", 0.05, samples)
  local noise = identify.white_noise{samples = samples, deviation = 0.3, seed = seed}
  return identify.data{u = theta, y = rest + noise, Ts = 0.05, inputs = {"theta"}, outputs = {"rest"}}
end
local part_data, part_fresh = swing(3000, 3), swing(1000, 4)
local part = identify.mlp(part_data, {regressors = "theta(k)", hidden = 4, starts = 3, iterations = 300, seed = 1})
keep("pendulum_part_mlp", part, part_fresh)
local part_error = identify.metrics(part_fresh.y, part:predict(part_fresh, 1)).RMSE

-- What cannot be measured from what can: the concentration in a reactor from its temperature now and before and from that of the coolant
-- (figure 4.5).
local function reactor(samples, seed)
  local coolant = identify.staircase{samples = samples, hold = {10, 60}, lower = 282, upper = 300, seed = seed}
  local feed = identify.staircase{samples = samples, hold = {20, 90}, lower = 0.9, upper = 1, seed = seed + 100}
  local run = pl.diagram(([[
plantloop: 1
import: [../../diagrams/parts/cstr.yaml]
blocks:
  coolant: %s
  feed: %s
  plant: {type: cstr, in: {coolant: coolant, c_feed: feed}, c_start: 0.9, T_start: 318}
simulation: {stop: %d, rtol: 1e-9, output_interval: 10}
record: [plant.T, plant.c]
]]):format(staircase(coolant, 10), staircase(feed, 10), samples * 10)):run()
  local T, c, n = sampled(run, "plant.T", 10, samples), sampled(run, "plant.c", 10, samples), samples
  return identify.data{u = columns(T:slice(2, n), T:slice(1, n - 1), coolant:slice(1, n - 1)), y = c:slice(2, n), Ts = 10,
                       inputs = {"T", "before", "coolant"}, outputs = {"c"}}
end
local sensor_data, sensor_fresh = reactor(2000, 5), reactor(800, 6)
local sensor = identify.mlp(sensor_data, {regressors = "T(k), before(k), coolant(k)", hidden = 8, starts = 3, iterations = 300, seed = 1})
local sensor_error = identify.metrics(sensor_fresh.y, sensor:predict(sensor_fresh, 1)).RMSE
keep("reactor_sensor_mlp", sensor, sensor_fresh)

-- The solution of an implicit control law: what predictive functional control of the tank answers to a level and a set point (figure 4.6).
local function answered(samples, seed)
  local run = pl.diagram(([[
plantloop: 1
blocks:
  h: {type: random_levels, lower: 0.3, upper: 1, seed: %d, rate: 5}
  off: {type: random_levels, lower: -0.1, upper: 0.1, seed: %d, rate: 5}
  w: clamp(h + off, 0.27, 1.03)
  control: {type: pfc, model: %s, in: {w: w, y: h}, horizon: 6, lambda: exp(-5/80), lower: 0.3, upper: 1.2, correction: false}
simulation: {stop: %d}
record: [h, w, control.u]
]]):format(seed, seed, "../../diagrams/book/models/tank_mlp.yaml", samples * 5)):run()
  return identify.data{u = columns(sampled(run, "h", 5, samples), sampled(run, "w", 5, samples)), y = sampled(run, "control.u", 5, samples),
                       Ts = 5, inputs = {"h", "w"}, outputs = {"u"}}
end
local law_data, law_fresh = answered(2500, 7), answered(800, 8)
local law = identify.mlp(law_data, {regressors = "h(k), w(k)", hidden = 12, starts = 3, iterations = 400, seed = 1})
local law_error = identify.metrics(law_fresh.y, law:predict(law_fresh, 1)).RMSE
keep("tank_law_mlp", law, law_fresh)

-- A controller at work, to be imitated: how it changes the pump by the error now and before and by the level (figure 4.7).
local function watched(samples, seed)
  local w = identify.staircase{samples = samples, hold = {20, 80}, lower = 0.25, upper = 1, seed = seed}
  w[1] = 0.5
  local run = pl.diagram(([[
plantloop: 1
import: [../../diagrams/parts/conical_tank.yaml]
blocks:
  w: %s
  control: {type: level_pi, in: {w: w, h: tank.h}, start: tank.u_start}
  tank: {type: conical_tank, in: control.u, h_start: 0.5}
simulation: {stop: %d, rtol: 1e-9, output_interval: 5}
record: [control.e, control.before, control.level, control.change]
]]):format(staircase(w, Ts), samples * Ts)):run()
  local signals = {}
  for i, name in ipairs{"control.e", "control.before", "control.level", "control.change"} do signals[i] = sampled(run, name, Ts, samples) end
  return identify.data{u = columns(signals[1], signals[2], signals[3]), y = signals[4], Ts = Ts, inputs = {"e", "before", "h"}, outputs = {"change"}}
end
local pupil_data, pupil_fresh = watched(3000, 9), watched(1000, 10)
local pupil = identify.mlp(pupil_data, {regressors = "e(k), before(k), h(k)", hidden = 8, starts = 3, iterations = 400, seed = 1})
local pupil_error = identify.metrics(pupil_fresh.y, pupil:predict(pupil_fresh, 1)).RMSE
keep("tank_pi_mlp", pupil, pupil_fresh)

-- The parameters of a controller over the level: gains by lambda tuning for linear models of the tank along it.
local levels, gains = pl.linspace(0.2, 1.05, 18), {}
local at_rest = pl.diagram [[
plantloop: 1
import: [../../diagrams/parts/conical_tank.yaml]
parameters: {h0: 0.5}
blocks:
  u: 0
  tank: {type: conical_tank, in: 1e-3*sqrt(2*9.81*h0)/5e-3 + u, h_start: h0}
simulation: {stop: 1}
]]
for i = 1, #levels do
  local linear = at_rest:with{h0 = levels[i]}:linearise{inputs = {"u"}, outputs = {"tank.h"}}
  local a, b = linear.A[1][1], linear.B[1][1]
  local tuned = pl.lambda_tuning{gain = -b / a, time_constant = -1 / a, dead_time = 0, lambda = 40}
  gains[i] = {tuned.kp, tuned.ki}
end
local schedule = identify.data{u = levels, y = pl.matrix(gains), Ts = Ts, inputs = {"h"}, outputs = {"kp", "ki"}}
local scheduler = identify.mlp(schedule, {regressors = "h(k)", hidden = 3, starts = 10, iterations = 400, seed = 1})
keep("tank_gains_mlp", scheduler, schedule)

-- The neutralisation of diagrams/book/nmpc_ph.yaml.
local function neutralisation(samples, seed)
  local flow = identify.staircase{samples = samples, hold = {2, 15}, lower = 13.2, upper = 17.6, seed = seed}
  flow[1] = 15.6
  local run = pl.diagram(([[
plantloop: 1
import: [../../diagrams/parts/ph_neutralisation.yaml]
blocks:
  base: %s
  plant: {type: ph_neutralisation, in: base}
simulation: {stop: %d, rtol: 1e-6, atol: 1e-9, output_interval: 25}
record: [plant.sensor]
]]):format(staircase(flow, 25), samples * 25)):run()
  return identify.data{u = flow, y = sampled(run, "plant.sensor", 25, samples), Ts = 25, inputs = {"u"}, outputs = {"y"}}
end
local ph_data, ph_fresh = neutralisation(1000, 11), neutralisation(400, 12)
local ph = identify.mlp(ph_data, {regressors = "y(k-1..4), u(k-1..4)", hidden = 10, starts = 3, iterations = 300, seed = 1})
local ph_free = identify.metrics(ph_fresh.y, ph:simulate(ph_fresh), {skip = 4}).RMSE
keep("ph_mlp", ph, ph_fresh)

local function yes(holds) return holds and "yes" or "no" end
print(("the tank in free run below 5 mm: %s; its inverse below 0.1 %% of the pump: %s"):format(yes(free_run < 5e-3), yes(inverse_error < 1e-3)))
print(("the rest of the pendulum's equation to its noise of 0.3: %s"):format(yes(part_error < 0.33)))
print(("the concentration below 0.002 mol/l: %s"):format(yes(sensor_error < 2e-3)))
print(("the predictive law below 0.1 %% of the pump: %s; the PI controller below 0.1 %%: %s"):format(yes(law_error < 1e-3), yes(pupil_error < 1e-3)))
print(("pH in free run below 0.05: %s"):format(yes(ph_free < 0.05)))
print(("the networks are those that the diagrams run: %s"):format(yes(all_as_stored)))

-- The loops that they work in.
local met = true
for _, name in ipairs{"network_unknown_part", "network_feedback_linearisation", "network_instantaneous_linearisation", "network_soft_sensor",
                      "network_control_law", "network_imitation", "network_inverse", "network_internal_model", "network_gains"} do
  local run = pl.load(("%s/diagrams/book/%s.yaml"):format(pl.project, name)):run()
  for _, verdict in ipairs(run:verdicts()) do met = met and verdict.met end
  run:figure(name):save(("out/%s.%s"):format(name, format))
end
print(("every loop does what its diagram expects: %s"):format(yes(met)))
