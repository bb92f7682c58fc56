-- What is the velocity form of a PI controller good for, and why is the derivative of the error not needed?
--
-- Figures 6.4 to 6.6 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
-- (2023). Figure 6.4 differentiates the control error; figure 6.5 filters it first and takes what enters the filter's
-- integrator as derivative; figure 6.6 is figure 6.5 with the gains 11 and 55.
-- plantloop script scripts/book/pi_velocity.lua [png|svg]
local pl = require "plantloop"

local format = arg[1] or "png"
local diagram = function(name) return pl.load(pl.project .. "/diagrams/book/" .. name .. ".yaml") end
local form_6_4, form_6_5, scheduled = diagram "pi_derivative", diagram "pi_velocity", diagram "pi_scheduled"

-- A derivative, made by ever faster filters, leads to figure 6.5 (figure 6.4).
local figure = pl.figure{title = "Figure 6.4 with a filtered derivative comes close to figure 6.5",
                         x = {label = "time t [s]", limits = {0, 0.06}}, height = 170}
local answer = figure:panel{y = "control signal u", limits = {0, 16}, height = 1.4}
local difference = figure:panel{y = "difference"}
local reference = form_6_4:run{stop = 0.06, max_step = 1e-4}
answer:line(reference.time, reference.implementable, {label = "figure 6.5", color = "blue"})
print "filter N   largest difference   in theory"
for i, N in ipairs{200, 1000, 5000} do
  local run = form_6_4:run{set = {N = N}, stop = 0.06, max_step = 1e-4}
  local look = {label = ("N = %g rad/s"):format(N), color = ({"vermillion", "green", "purple"})[i]}
  difference:line(run.time, run.error, look)
  look.style = "dashed"
  answer:line(run.time, run.u, look)
  local r = 100 / N
  print(("%8g   %18.4f   %.4f"):format(N, run:measure("min", "error"),
                                        -11 * r / (1 - r) * (r ^ (r / (1 - r)) - r ^ (1 / (1 - r)))))
end
figure:save("out/figure_6_4." .. format)

-- The answer to a unit step, by the block and by elementary blocks (figures 6.5 and 6.6).
local run = form_6_5:run{output_interval = 0.001}
figure = pl.figure{title = "The PI controller of figure 6.6 answers a unit step of the error",
                   x = {label = "time t [s]", limits = {0, 1}}, height = 170}
local step = figure:panel{y = "control signal u", limits = {0, 80}, height = 1.4}
step:line(run.time, run.u, {label = "elementary blocks", color = "blue"})
step:line(run.time, run["controller.u"], {label = "block velocity_pi", color = "vermillion", style = "dashed"})
local t = pl.linspace(0.05, 0.95, 10)
step:markers(t, 11 * (1 - pl.exp(-100 * t)) + 55 * (t - (1 - pl.exp(-100 * t)) / 100),
             {label = "(11 + 55/s) 100/(s + 100)", color = "black", marker = "ring"})
local inside = figure:panel{y = "control error", limits = {0, 1.2}}
inside:line(run.time, run.e, {label = "e", color = "grey"})
inside:line(run.time, run.z, {label = "filtered, z", color = "green"})
figure:save("out/figure_6_5_6_6." .. format)
print "\n   t [s]   elementary blocks   velocity_pi   expected"
for _, row in ipairs{{0.01, 7.155660}, {0.1, 15.949526}, {1, 65.45}} do
  print(("%8g   %17.6f   %11.6f   %.6f"):format(row[1], run:at("u", row[1]), run:at("controller.u", row[1]), row[2]))
end

-- Gains that vary: where they stand matters.
run = scheduled:run()
figure = pl.figure{title = "Falling gains move the control signal only behind the integrator",
                   x = {label = "time t [s]", limits = {0, 4}}, height = 170}
local signal = figure:panel{y = "control signal u", limits = {-10, 40}, height = 1.6}
signal:shade{from = 1, ["until"] = 2, label = "gains fall"}
signal:line(run.time, run["velocity.u"], {label = "in front of the integrator", color = "blue"})
signal:line(run.time, run.usual, {label = "behind the integrator", color = "vermillion"})
figure:panel{y = "gain K_1 [1/s]", limits = {0, 60}}:line(run.time, run.k1, {color = "green"})
figure:panel{y = "control error e", limits = {-1.5, 1.5}}:line(run.time, run.e, {color = "grey"})
figure:save("out/pi_scheduled." .. format)

local apart = run:measure("max_abs", "difference")
local constant = scheduled:run{set = {change = 0}}:measure("max_abs", "difference")
print(("\nConstant gains: the two places differ by %.1g; gains that fall to the half: by %.4g (expected 13.75):")
  :format(constant, apart))
print(("a velocity form can be scheduled without a bump. Drawn: out/figure_6_4, figure_6_5_6_6 and pi_scheduled.%s")
  :format(format))
