-- How close does the velocity form of a pendulum come to the pendulum, and what does it depend on?
--
-- Figure 5.17 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods (2023).
-- The velocity form needs the derivative of the force; a filter N s/(s + N) stands for it.
-- plantloop script scripts/book/pendulum.lua [png|svg]
local pl = require "plantloop"

local diagram = pl.load(pl.project .. "/diagrams/book/pendulum.yaml")
local colours = {[20] = "vermillion", [100] = "green", [1000] = "purple"}
local expected = {[20] = 0.01839, [100] = 0.003803, [1000] = 0.0003807}  -- rad
local run_with = function(N) return diagram:run{set = {N = N}} end

local figure = pl.figure{title = "A damped pendulum and its velocity form",
                         x = {label = "time t [s]", limits = {0, 31}}, height = 200}
local angle = figure:panel{y = "angle θ [rad]", limits = {0, 1.2}, height = 1.2}
local difference = figure:panel{y = "difference [mrad]"}
local summary = figure:panel{x = {label = "pole of the filter N [rad/s]", scale = "log", limits = {10, 10000}},
                             y = {label = "largest difference [mrad]", scale = "log", limits = {0.01, 100}},
                             height = 0.8}

-- The motion, and what each filter costs.
local original = diagram:run{set = {N = 100}, output_interval = 0.01}
angle:line(original.time, original.theta, {label = "original", color = "blue"})
print "      N   largest difference [rad]   expected"
for _, N in ipairs{20, 100, 1000} do
  local run = run_with(N)
  local look = {label = ("N = %g"):format(N), color = colours[N]}
  if N == 20 then
    angle:line(run.time, run["velocity.theta"], {label = "velocity form, N = 20", color = look.color, style = "dashed"})
  end
  difference:line(run.time, 1000 * run.error, look)
  print(("%7g   %24.7f   %g"):format(N, run:measure("max_abs", "error"), expected[N]))
end

-- The whole range of filters.
local N = pl.logspace(10, 10000, 13)
local largest = pl.zeros(#N)
for i = 1, #N do largest[i] = run_with(N[i]):measure("max_abs", "error") end
local speed = pl.max(pl.abs(pl.diff(original.theta) / pl.max(pl.diff(original.time), 1e-12)))  -- rad/s
summary:line(N, 1000 * speed / N, {label = "max |dθ/dt| / N", color = "grey", style = "dashed"})
summary:line(N, 1000 * largest, {label = "measured", color = "blue"})
for n, colour in pairs(colours) do
  summary:markers({n}, {1000 * run_with(n):measure("max_abs", "error")}, {color = colour})
end
local drawn = "out/figure_5_17." .. (arg[1] or "png")
figure:save(drawn)

print "\n  t [s]   theta [rad]   expected"
local times = {2, 6.99, 12.99, 18.99, 24.99, 31}
local angles = {0.207979, 0.333853, 0.713764, 1.105944, 0.518951, 0.165872}
for i, t in ipairs(times) do print(("%7g   %11.6f   %.6f"):format(t, original:at("theta", t), angles[i])) end
print(("\nThey differ by the lag of the filter, at most %.3g rad/s divided by N. Drawn: %s")
  :format(largest[#largest] * N[#N], drawn))
