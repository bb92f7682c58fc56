-- Data that are not those of the model: every kind of model says the same.
local identify = pl.identify
local u1, u2, y = identify.prbs{bits = 8}, identify.prbs{bits = 7, samples = 255}, pl.zeros(255)
for k = 2, 255 do y[k] = 0.8 * y[k - 1] + 0.5 * u1[k - 1] + 0.1 * u2[k - 1] end
local function rig(Ts, names, output)
  local columns = {}
  for k = 1, 255 do columns[k] = names[1] == "u2" and {u2[k], u1[k]} or {u1[k], u2[k]} end
  return identify.data{u = pl.matrix(columns), y = y, Ts = Ts, inputs = names, outputs = {output}}
end
local data = rig(0.1, {"u1", "u2"}, "y")
local swapped, slow, other = rig(0.1, {"u2", "u1"}, "y"), rig(5, {"u1", "u2"}, "y"), rig(0.1, {"u1", "u2"}, "z")
local lags = "y(k-1), u1(k-1), u2(k-1)"
local models = {
  {"linear", identify.arx(data, {na = 1, nb = 1})},
  {"state space", identify.state_space(data, {order = 1})},
  {"regression", identify.regression(data, {regressors = lags})},
  {"mlp", identify.mlp(data, {regressors = lags, hidden = 1, starts = 1, iterations = 5})},
  {"radial", identify.rbf_network(data, {regressors = lags, functions = 5})},
  {"local models", identify.local_models(data, {regressors = lags, models = 2})},
  {"process", identify.gaussian_process(data, {regressors = lags, starts = 1, iterations = 3})},
  {"neural", identify.neural_state_space(data, {order = 1, hidden = 1, starts = 1, iterations = 3})},
}
for _, m in ipairs(models) do
  print(m[1])
  says(m[2].simulate, m[2], swapped)
  says(m[2].simulate, m[2], slow)
  says(m[2].simulate, m[2], other)
  says(m[2].predict, m[2], swapped)
  says(m[2].residuals, m[2], slow)
end
local process = models[7][2]
says(process.uncertain, process, swapped)
says(process.add, process, swapped)
says(identify.mlp, data, {regressors = lags, hidden = 1, starts = 1, validation = slow})
says(identify.order_table, data, {validation = swapped})
print("rounded times", (pcall(models[4][2].simulate, models[4][2], rig(0.10005, {"u1", "u2"}, "y"))))
