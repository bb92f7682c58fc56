-- Options of free runs: what each kind of model understands, and that nothing is taken without effect.
local identify = pl.identify
local u, y = identify.prbs{bits = 6}, pl.zeros(63)
for k = 2, 63 do y[k] = 0.8 * y[k - 1] + 0.5 * u[k - 1] end
local data = identify.data{u = u, y = y, Ts = 0.1}
local lags = "y(k-1), u(k-1)"
local models = {
  {"linear", identify.arx(data, {na = 1, nb = 1})},
  {"state space", identify.state_space(data, {order = 1})},
  {"regression", identify.regression(data, {regressors = lags})},
  {"mlp", identify.mlp(data, {regressors = lags, hidden = 1, starts = 1, iterations = 5})},
  {"process", identify.gaussian_process(data, {regressors = lags, starts = 1, iterations = 3})},
  {"neural", identify.neural_state_space(data, {order = 1, hidden = 1, starts = 1, iterations = 3})},
}
for _, m in ipairs(models) do
  print(m[1])
  says(m[2].simulate, m[2], data, {foo = 1})
  says(m[2].simulate, m[2], data, {start = "zro"})
  says(m[2].simulate, m[2], data, {start = "zero"})
end
says(identify.instrumental, data, {na = 1, nb = 1, passes = 3})
says(data.part, data, 64)
