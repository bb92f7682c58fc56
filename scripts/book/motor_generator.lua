-- Which linear model describes a motor that drives a generator around 8.5 V, and which estimate finds it in noise?
--
-- Figures 2.9 to 2.24 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
-- (2023). The measured rig is not available: the plant is diagrams/book/motor_generator.yaml, whose model at the operating
-- voltage is the book's (2.22). The book's (2.20) has another gain than its (2.19) and (2.22) and cannot be met.
-- plantloop script scripts/book/motor_generator.lua [png|svg]
local pl = require "plantloop"
local identify = pl.identify

local format = arg[1] or "png"
local plant = pl.load(pl.project .. "/diagrams/book/motor_generator.yaml")
local Ts, sigma = 0.02, 0.0105
local function save(figure, number) figure:save(("out/figure_2_%s.%s"):format(number, format)) end

-- The static curve by a ramp of 5 mV/s (figure 2.9), and a step (figure 2.10).
local ramp = plant:run{set = {experiment = 4}, stop = 2000, output_interval = 2}
local figure = pl.figure{title = "Static characteristic: the bulbs ignite at about 5 V", x = "input u [V]", y = "output y [V]"}
figure:line(ramp.u, ramp.y, {color = "blue"})
save(figure, 9)

local step = plant:run{set = {experiment = 2}, stop = 1.5, output_interval = 0.01}
figure = pl.figure{title = "Step from 8.5 V to 9.5 V", x = "time t [s]"}
figure:panel{y = "y [V]"}:line(step.time, step.y, {color = "blue"})
figure:panel{y = "u [V]", height = 0.5}:line(step.time, step.u, {color = "grey"})
save(figure, 10)
print(("step: gain %.4f, overshoot %.2f %%"):format(step.y[#step.y] - step.y[1], 100 * (pl.max(step.y) - step.y[1]) /
                                                      (step.y[#step.y] - step.y[1]) - 100))

-- Samples every 0.02 s with noise, about the operating point.
local function record(experiment, samples, seed)
  local run = plant:run{set = {experiment = experiment}, stop = samples * Ts, output_interval = Ts}
  local t = pl.range(0, (samples - 0.5) * Ts, Ts)
  local y = run:at("y", t) + identify.white_noise{samples = samples, deviation = sigma, seed = seed, portable = true}
  return identify.data{u = run:at("u", t + 1e-9) - 8.5, y = y, Ts = Ts, inputs = {"u [V]"}, outputs = {"y [V]"}}
end
local raw = record(1, 635, 7919)
local data = raw:detrend()
local validation = record(3, 600, 11)

-- Input and response about the operating point, each with the magnitude of its spectrum (figures 2.11 and 2.12); that of the
-- input is empty at 2 pi/0.1 s.
local w, power = identify.periodogram(data.u, Ts)
local _, power_y = identify.periodogram(data.y, Ts)
for number, c in pairs{[11] = {"A binary sequence of 127 bits", "u - 8.5 V [V]", data.u, power, "stairs"},
                       [12] = {"The response to the binary sequence", "y - mean [V]", data.y, power_y, "line"}} do
  figure = pl.figure{title = c[1], columns = 2}
  local top = figure:panel{x = {label = "time t [s]", limits = {0, 12.7}}, y = c[2]}
  top[c[5]](top, data.time, c[3], {color = "blue"})
  figure:panel{x = {label = "frequency ω [rad/s]", limits = {0, 157}}, y = "magnitude", lines = {{x = 2 * pl.pi / 0.1, label = "clock"}}}
    :line(w, c[4] ^ 0.5, {color = "blue"})
  save(figure, number)
end
-- The mean of the power around a frequency, over that of the lowest ones.
local function share(around)
  local low, there, n_low, n_there = 0, 0, 0, 0
  for i = 2, #w do
    if w[i] < 10 then low, n_low = low + power[i], n_low + 1 end
    if math.abs(w[i] - around) < 2 then there, n_there = there + power[i], n_there + 1 end
  end
  return there / n_there / (low / n_low)
end
print(("power of the input: half at 27.8 rad/s: %s; none at the clock's 62.8 rad/s: %s"):format(
  math.abs(share(27.8) - 0.5) < 0.1 and "yes" or share(27.8), share(2 * pl.pi / 0.1) < 0.01 and "yes" or share(2 * pl.pi / 0.1)))

-- Fourier analysis, and spectral analysis with a Hamming window of 35 lags (figure 2.13).
local etfe = identify.fourier(data)
local function bode(title)
  local f = pl.figure{title = title, x = {label = "frequency ω [rad/s]", scale = "log", limits = {0.5, 157}}, height = 130}
  return f, f:panel{y = {label = "magnitude", scale = "log", limits = {0.003, 3}}},
         f:panel{y = {label = "phase [rad]", limits = {-14, 2}}, height = 0.7}
end
local magnitude, phase
local grid = identify.frequencies{from = 0.5, Ts = Ts, count = 200}
local spectral = identify.spectral(data, {lags = 35, w = grid})
figure, magnitude, phase = bode "Frequency response without smoothing and with it"
magnitude:markers(etfe.w, etfe.magnitude, {color = "grey", label = "Fourier analysis", marker = "dot"})
magnitude:line(grid, spectral.magnitude, {color = "blue", label = "spectral analysis, 35 lags"})
phase:markers(etfe.w, etfe.phase, {color = "grey", marker = "dot"})
phase:line(grid, spectral.phase, {color = "blue"})
save(figure, 13)

-- The order from the information matrix, the delay from output-error models.
local determinants, order = identify.information_test(data, {highest = 4, delay = 2})
local delays, errors = identify.delay_table(data, {order = 2, delay = {0, 5}})
local delay = 0
for i = 1, #errors do
  if errors[i] < errors[delay + 1] then delay = math.tointeger(delays[i]) end
end
print(("det(Psi'Psi/N) for orders 1 to 4: %.3g %.3g %.3g %.3g; order %d"):format(determinants[1], determinants[2],
                                                                              determinants[3], determinants[4], order))
print(("delay of the best output-error model: %d samples"):format(delay))

-- Plain and filtered least squares, and the output-error model with one numerator coefficient (2.22).
local models = {
  {name = "least squares", color = "vermillion", model = identify.arx(data, {na = 2, nb = 2, delay = 2})},
  {name = "filtered least squares", color = "blue", model = identify.filtered(data, {na = 2, nb = 2, delay = 2})},
  {name = "output error, one coefficient", color = "green", model = identify.oe(data, {nb = 1, nf = 2, delay = 2})},
}
print "                                     a1         a2         b1         b2      gain   RMSE identified  validated"
for i, m in ipairs(models) do
  local A = i == 1 and m.model.A or m.model.F
  m.simulated = m.model:simulate(data, {start = "zero"})
  m.validated = m.model:simulate(validation, {start = "zero"})
  m.mean = pl.mean(validation.y - m.validated)
  m.own = identify.metrics(data.y, m.simulated).RMSE
  m.other = identify.metrics(validation.y, m.validated + m.mean).RMSE
  print(("%-30s %10.6f %10.6f %10.6f %10.6f %9.4f %17.4f %10.4f"):format(m.name, A[2], A[3], m.model.B[1], #m.model.B > 1 and m.model.B[2] or 0,
                                                                        m.model.gain, m.own, m.other))
end

-- Residuals of the one-step error of least squares, and of the simulated output of the filtered estimate: over time and their
-- distribution (figures 2.14 and 2.15), with the input (2.16 and 2.17), with themselves (2.18 and 2.19).
local function correlations(e, title, with_input, with_itself)
  local ee, eu = identify.autocorrelation(e), identify.cross_correlation(e, data.u)
  for number, c in pairs{[with_itself] = ee, [with_input] = eu} do
    local f = pl.figure{title = title, x = "lag [samples]", y = number == with_itself and "correlation of e with e" or "correlation of e with u",
                        bands = {{lower = -c.band, upper = c.band, label = "95 %"}}}
    f:line(c.lag, c.r, {style = "line_points", color = "blue"})
    save(f, number)
  end
  local outside = 0
  for i = 2, #ee.r do outside = outside + (math.abs(ee.r[i]) > ee.band and 1 or 0) end
  return outside / (#ee.r - 1)
end
local function histogram(e, title, number)
  local h = identify.histogram(e)
  local f = pl.figure{title = title, columns = 2}
  f:panel{x = {label = "time t [s]", limits = {0, 12.7}}, y = "residual [V]"}:line(data.time, e, {color = "blue"})
  local right = f:panel{x = "residual [V]", y = "samples"}
  right:stairs(pl.join(h.edges), pl.join(h.counts, h.counts[#h.counts]), {color = "blue", label = "residuals"})
  right:line(h.middles, h.normal, {color = "vermillion", label = "normal density"})
  save(f, number)
end
histogram(models[1].model:residuals(data), "Residuals of least squares", 14)
histogram(models[2].model:residuals(data), "Residuals of filtered least squares", 15)
local plain = correlations(models[1].model:residuals(data), "Residuals of least squares", 16, 18)
local filtered = correlations(models[2].model:residuals(data), "Residuals of filtered least squares", 17, 19)
print(("residuals outside of the 95 %% band: %.0f %% of the lags by least squares, %.0f %% filtered"):format(100 * plain, 100 * filtered))

-- Comparison in time: least squares and the filtered estimate (figures 2.20 and 2.21), the model of one coefficient (2.23).
local function in_time(number, d, simulated, title, which)
  local f = pl.figure{title = title, x = {label = "time t [s]", limits = {0, 4}}}
  local top, bottom = f:panel{y = "y [V]"}, f:panel{y = "error [V]", height = 0.5}
  top:markers(d.time, d.y, {marker = "dot", color = "grey", label = "measured"})
  for _, i in ipairs(which) do
    local y = models[i][simulated] + (d == validation and models[i].mean or 0)
    top:line(d.time, y, {label = models[i].name, color = models[i].color})
    bottom:line(d.time, d.y - y, {color = models[i].color})
  end
  save(f, number)
end
in_time(20, data, "simulated", "Free run on the data of identification", {1, 2})
in_time(21, validation, "validated", "Free run on pulses that no model has seen", {1, 2})
in_time(23, validation, "validated", "Free run of the model with one coefficient, on the pulses", {3})

-- Comparison in frequency with both analyses: the filtered estimate (figure 2.22), the model of one coefficient (2.24).
for number, m in pairs{[22] = models[2], [24] = models[3]} do
  figure, magnitude, phase = bode("Frequency response of " .. m.name)
  local r = m.model:response(grid)
  magnitude:markers(etfe.w, etfe.magnitude, {color = "grey", label = "Fourier analysis", marker = "dot"})
  magnitude:line(grid, spectral.magnitude, {color = "black", label = "spectral analysis", style = "dashed"})
  magnitude:line(grid, r.magnitude, {color = m.color, label = m.name})
  phase:line(grid, spectral.phase, {color = "black", style = "dashed"})
  phase:line(grid, r.phase, {color = m.color})
  save(figure, number)
  -- Where the input has power, in decibels off the smoothed response.
  local worst = 0
  for i = 1, #grid do
    if grid[i] > 2 and grid[i] < 30 then worst = math.max(worst, math.abs(20 * math.log(r.magnitude[i] / spectral.magnitude[i], 10))) end
  end
  print(("%s: within 3 dB of the spectral analysis from 2 to 30 rad/s: %s"):format(m.name, worst < 3 and "yes" or ("no, %.2f dB"):format(worst)))
end
print(("The filtered estimate simulates %.1f times better than least squares in validation."):format(models[1].other / models[2].other))
