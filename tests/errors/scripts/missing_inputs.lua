-- A free run needs its inputs and its first outputs, whatever the model is.
local identify = pl.identify
local u, y = identify.prbs{bits = 6}, pl.zeros(63)
for k = 2, 63 do y[k] = 0.8 * y[k - 1] + 0.5 * u[k - 1] end
local data = identify.data{u = u, y = y, Ts = 0.1}
local holed, late = u:slice(1, 63), y:slice(1, 63)
holed[20], late[1] = pl.nan, pl.nan
local gap = identify.data{u = holed, y = y, Ts = 0.1}
local start = identify.data{u = u, y = late, Ts = 0.1}
local lags = "y(k-1), u(k-1)"
local models = {
  {"linear", identify.arx(data, {na = 1, nb = 1})},
  {"state space", identify.state_space(data, {order = 1})},
  {"regression", identify.regression(data, {regressors = lags})},
  {"mlp", identify.mlp(data, {regressors = lags, hidden = 1, starts = 1, iterations = 5})},
  {"local models", identify.local_models(data, {regressors = lags, models = 2})},
  {"process", identify.gaussian_process(data, {regressors = lags, starts = 1, iterations = 3})},
  {"neural", identify.neural_state_space(data, {order = 1, hidden = 1, starts = 1, iterations = 3})},
}
for _, m in ipairs(models) do
  print(m[1])
  says(m[2].simulate, m[2], gap)
  says(m[2].simulate, m[2], start)
end
says(models[6][2].uncertain, models[6][2], gap)
says(models[3][2].simulate, models[3][2], identify.join(data, gap))
print(identify.order_table(data, {validation = gap})[1].simulated)
