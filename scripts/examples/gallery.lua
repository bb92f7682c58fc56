-- What does each kind of figure look like, in each theme?
--
-- Draws out/gallery/THEME/NAME.svg; `plantloop script gallery.lua png` and `pdf` draw in these formats.
local pl = require "plantloop"
local format = arg[1] or "svg"

local pi = math.pi

local function noise(samples, seed) return pl.identify.white_noise{samples = samples, seed = seed} end

-- Of a second-order lag with natural frequency w and damping z below one.
local function step_response(t, w, z)
  local wd = w * math.sqrt(1 - z ^ 2)
  t = pl.where(t:greater(0), t, 0)
  return 1 - pl.exp(-z * w * t) * (pl.cos(wd * t) + z * w / wd * pl.sin(wd * t))
end

local function heights(x, y, f)
  local rows = {}
  for j = 1, #y do
    rows[j] = {}
    for i = 1, #x do rows[j][i] = f(x[i], y[j]) end
  end
  return pl.matrix(rows)
end

local figures = {}

-- Lines, stairs, bands, reference lines, remarks, two axes.
function figures.line(look)
  look.title, look.x = "Pressure control with a disturbance", "time [s]"
  local figure = pl.figure(look)
  local t = pl.linspace(0, 20, 801)
  local p = 2 + step_response(t - 1, 1.2, 0.4) - 0.6 * (step_response(t - 10, 1.2, 0.4) - step_response(t - 11.5, 1.2, 0.4))
  local panel = figure:panel{y = "pressure [bar]", right_label = "valve [%]", right_limits = {0, 100}, lines = {{y = 3.3, label = "limit", style = "dashed"}},
    bands = {{from = 10, ["until"] = 11.5, label = "leak"}}}
  panel:line(t, p, {label = "p"})
  panel:stairs(pl.range(0, 20, 0.5), pl.where(pl.range(0, 20, 0.5):less(1), 20, 46), {label = "u", right = true})
  panel:annotate{x = t[pl.find(p:equal(pl.max(p)))[1]], y = pl.max(p), label = "largest"}
  return figure
end

function figures.band(look)
  look.title, look.x, look.y = "A model that knows what it does not know", "x", "y"
  local figure = pl.figure(look)
  local x = pl.linspace(-3, 3, 301)
  local mean, deviation = pl.sin(2 * x), 0.05 + 0.5 / (1 + pl.exp(-6 * (x:abs() - 2)))
  figure:band(x, mean - 2 * deviation, mean + 2 * deviation, {label = "±2σ"})
  figure:line(x, mean, {label = "mean"})
  return figure
end

function figures.stem(look)
  look.title, look.x, look.y = "Impulse response of a sampled system", "sample k", "g(k)"
  local figure = pl.figure(look)
  local k = pl.range(0, 30)
  figure:stem(k, pl.exp(-0.1 * k) * pl.cos(0.6 * k))
  return figure
end

function figures.scatter(look)
  look.title, look.x, look.y = "Poles of 400 uncertain loops", "Re s [1/s]", "Im s [1/s]"
  local figure = pl.figure(look)
  local a, b = noise(400, 1), noise(400, 2)
  figure:scatter(-1.4 + 0.3 * a, 2 + 0.4 * b, {label = "upper half", opacity = 0.6})
  figure:scatter(-1.4 + 0.3 * a, -2 - 0.4 * b, {label = "lower half", opacity = 0.6})
  return figure
end

function figures.bar(look)
  look.title, look.y = "Evaluations per simulated second", "evaluations"
  local figure = pl.figure(look)
  local names = {"euler", "heun", "rk4", "dopri5", "bdf"}
  figure:bar({1000, 400, 160, 78, 61}, {names = names, nth = 1, of = 2, label = "pendulum"})
  figure:bar({9000, 6100, 3600, 2900, 140}, {names = names, nth = 2, of = 2, label = "stiff tank"})
  return figure
end

function figures.histogram(look)
  look.title, look.x = "Overshoot of 1000 loops", "overshoot [%]"
  local figure = pl.figure(look)
  local z = 0.4 + 0.07 * noise(1000, 3)
  figure:histogram(100 * pl.exp(-pi * z / pl.sqrt(1 - z ^ 2)), {density = true, median = true})
  return figure
end

function figures.error_bars(look)
  look.title, look.x, look.y = "Static gain, five measurements each", "valve opening [%]", "flow [l/min]"
  local figure = pl.figure(look)
  local x = pl.range(10, 90, 10)
  figure:error_bars(x, 60 * pl.tanh(x / 55) + 1.5 * noise(#x, 4), 1.5 + 0.03 * x, {label = "measured, ±2σ"})
  local u = pl.linspace(0, 100, 101)
  figure:line(u, 60 * pl.tanh(u / 55), {label = "model"})
  return figure
end

function figures.quantile_fan(look)
  look.title, look.x, look.y = "200 step responses", "time [s]", "output y"
  local figure = pl.figure(look)
  local t, runs = pl.linspace(0, 10, 201), {}
  local z, w = noise(200, 5), noise(200, 6)
  for i = 1, 200 do
    runs[i] = step_response(t, 2.4 * (1 + 0.05 * w[i]), math.min(0.9, math.max(0.05, 0.25 + 0.06 * z[i]))):table()
  end
  figure:quantile_fan(t, pl.transpose(pl.matrix(runs)))
  return figure
end

function figures.region(look)
  look.title, look.x, look.y = "Where the sampled loop is stable", "a_1", "a_2"
  local figure = pl.figure(look)
  figure:region({-2, 2, 0}, {1, 1, -1}, {label = "both roots inside the unit circle"})
  return figure
end

function figures.events(look)
  look.title, look.x, look.y = "A ball that bounces", "time [s]", "height [m]"
  local figure = pl.figure(look)
  local run = pl.load(pl.project .. "/diagrams/classics/bouncing_ball.yaml"):run{stop = 12}
  figure:line(run.time, run.h)
  figure:events(run:events()["v.reset"])
  return figure
end

function figures.heat_map(look)
  look.title, look.x, look.y = "Cost over two gains", "K_p", "K_d"
  local figure = pl.figure(look)
  local g = pl.linspace(-3, 3, 121)
  figure:heat_map(heights(g, g, function(a, b) return math.log(0.05 + (1 - a) ^ 2 + 1.5 * (b - 0.3 * a ^ 2) ^ 2, 10) end), g, g,
    {scale = "log_{10} J"})
  return figure
end

local function peaks(a, b)
  return 3 * (1 - a) ^ 2 * math.exp(-a ^ 2 - (b + 1) ^ 2) - 10 * (a / 5 - a ^ 3 - b ^ 5) * math.exp(-a ^ 2 - b ^ 2)
    - math.exp(-(a + 1) ^ 2 - b ^ 2) / 3
end

function figures.contour(look)
  look.title, look.columns = "A function of two variables", 2
  local figure = pl.figure(look)
  local g = pl.linspace(-3, 3, 121)
  local z = heights(g, g, peaks)
  figure:panel{title = "lines", x = "x_1", y = "x_2"}:contour(z, g, g)
  figure:panel{title = "filled", x = "x_1"}:contour(z, g, g, {filled = true})
  return figure
end

function figures.surface(look)
  look.title = "A function of two variables"
  local figure = pl.figure(look)
  local g = pl.linspace(-3, 3, 49)
  figure:panel{x = "x_1", y = "x_2"}:surface(heights(g, g, peaks), g, g, {z_label = "f"})
  return figure
end

function figures.trajectory(look)
  look.title = "Lorenz' attractor"
  local figure = pl.figure(look)
  local run = pl.load(pl.project .. "/diagrams/classics/lorenz.yaml"):run{output_interval = 0.01}
  figure:panel{x = "x", y = "y"}:trajectory(run.x, run.y, run.z, {z_label = "z"})
  return figure
end

function figures.phase_portrait(look)
  look.title = "Van der Pol's oscillator"
  local figure = pl.figure(look)
  local diagram = pl.load(pl.project .. "/diagrams/classics/van_der_pol.yaml")
  local run = diagram:run{stop = 20, output_interval = 0.02}
  local x, v, dx, dv = {}, {}, {}, {}
  for a = -3, 3, 0.25 do
    for b = -4, 4, 0.5 do
      x[#x + 1], v[#v + 1], dx[#dx + 1], dv[#dv + 1] = a, b, b, (1 - a ^ 2) * b - a
    end
  end
  local panel = figure:panel{x = "x", y = "dx/dt"}
  panel:phase_portrait(x, v, dx, dv)
  panel:line(run.x, run.v)
  return figure
end

local num, den = {4}, {0.1, 1.1, 1, 0}

function figures.bode(look)
  look.title = "Bode diagram of L(s) = 4 / (s (s + 1) (0.1 s + 1))"
  local figure = pl.figure(look)
  figure:bode(num, den, {from = 0.1, to = 100})
  return figure
end

function figures.nyquist(look)
  look.title = "Nyquist diagram of L(s)"
  local figure = pl.figure(look)
  figure:nyquist({3}, {1, 3, 3, 1})
  return figure
end

function figures.nichols(look)
  look.title = "Nichols chart of L(s)"
  local figure = pl.figure(look)
  figure:nichols(num, den)
  return figure
end

function figures.root_locus(look)
  look.title = "Root locus of k (s + 3) / (s (s + 1) (s^2 + 4 s + 8))"
  local figure = pl.figure(look)
  figure:root_locus({1, 3}, {1, 5, 12, 8, 0}, {gain = 2})
  return figure
end

function figures.pole_zero(look)
  look.title = "Poles and zeros of a sampled filter"
  local figure = pl.figure(look)
  figure:pole_zero({1, 0.6, 0.5}, {1, -1.2, 0.9, -0.25}, {sampled = true})
  return figure
end

function figures.step_response(look)
  look.title, look.x, look.y = "Step response of a position loop", "time [s]", "position [m]"
  local figure = pl.figure(look)
  local t = pl.linspace(0, 8, 801)
  figure:step_response(t, step_response(t, 2, 0.35), {to_value = 1})
  return figure
end

-- A record of a lag with noise, and two models of it, for the figures of identification.
local t = pl.range(0, 60, 0.2)
local measured = 20 + 18 * step_response(t - 4, 0.25, 0.45) - 9 * step_response(t - 34, 0.25, 0.45) + 0.4 * noise(#t, 7)
local first = 20 + 18 * (1 - pl.exp(-pl.where(t:greater(5), t - 5, 0) / 4.6)) - 9 * (1 - pl.exp(-pl.where(t:greater(35), t - 35, 0) / 4.6))
local second = 20 + 18.2 * step_response(t - 4.1, 0.25, 0.47) - 9.1 * step_response(t - 34.1, 0.25, 0.47)

function figures.comparison(look)
  look.title, look.x, look.y = "Two models and what was measured", "time [s]", "temperature [°C]"
  local figure = pl.figure(look)
  figure:comparison(t, measured, pl.transpose(pl.matrix{first:table(), second:table()}), {names = {"first order", "second order"}})
  return figure
end

function figures.residuals(look)
  look.title, look.x = "What the second model leaves", "time [s]"
  local figure = pl.figure(look)
  figure:residuals(t, measured, second)
  return figure
end

function figures.correlation(look)
  look.title = "What the first model leaves"
  local figure = pl.figure(look)
  figure:correlation(measured - first)
  return figure
end

function figures.spectrum(look)
  look.title, look.y = "A vibration of 35 Hz in noise", "density [1/Hz]"
  local figure = pl.figure(look)
  local s = pl.range(0, 16383) / 1000
  figure:spectrum(pl.sin(2 * pi * 35 * s) + 0.5 * noise(#s, 8), {period = 0.001})
  return figure
end

function figures.coverage(look)
  look.title = "Where the training data lie, and where the loop went"
  local figure = pl.figure(look)
  local u, y = 0.9 * noise(3000, 9), {0}
  for k = 2, #u do y[k] = 0.82 * y[k - 1] + 0.3 * u[k - 1] end
  local a = pl.linspace(0, 6.3, 180)
  figure:panel{x = "y(k-1)", y = "u(k-1)"}:coverage(y, u, {test_x = 1.75 * pl.cos(a), test_y = 1.5 * pl.sin(1.2 * a + 0.5)})
  return figure
end

function figures.weighting(look)
  look.title, look.x, look.y = "Weights of four local models", "operating point q", "weight"
  local figure = pl.figure(look)
  local q, weights, sum = pl.linspace(0, 1, 201), {}, 0
  for i = 1, 4 do
    weights[i] = pl.exp(-0.5 * ((q - (i - 1) / 3) / 0.13) ^ 2)
    sum = sum + weights[i]
  end
  for i = 1, 4 do weights[i] = (weights[i] / sum):table() end
  figure:weighting(q, pl.transpose(pl.matrix(weights)))
  return figure
end

function figures.network(look)
  look.title = "A network after pruning"
  local figure = pl.figure(look)
  local w = noise(4 * 6 + 6, 10)
  figure:network({4, 6, 1}, pl.where(w:abs():less(0.45), 0, w),
    {inputs = {"y(k-1)", "y(k-2)", "u(k-1)", "u(k-2)"}, outputs = {"\\hat{y}(k)"}})
  return figure
end

local names = {}
for name in pairs(figures) do names[#names + 1] = name end
table.sort(names)
for _, theme in ipairs{"light", "dark", "print"} do
  for _, name in ipairs(names) do
    figures[name]{theme = theme}:save(("out/gallery/%s/%s.%s"):format(theme, name, format))
  end
end
print(("%d figures in three themes: out/gallery"):format(#names))
