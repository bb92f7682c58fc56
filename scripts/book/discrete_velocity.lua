-- How close does the velocity form come to a discrete system, and how close a blend of seven models?
--
-- Figures 5.18 and 5.23 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods (2023):
-- y(k+1) = y/(1 + y^2) + u^3 and equation (5.21), a continuous system with a dead time.
-- plantloop script scripts/book/discrete_velocity.lua [png|svg]
local pl = require "plantloop"

local format = arg[1] or "png"
local run = pl.load(pl.project .. "/diagrams/book/discrete_velocity.yaml"):run{output_interval = 0.01}
local time = {label = "time t [s]", limits = {0, 25}}

local figure = pl.figure{title = "A discrete system and its velocity form", x = time, height = 170}
local outputs = figure:panel{y = "output", height = 1.4}
outputs:stairs(run.time, run.y, {label = "discrete", color = "blue"})
outputs:line(run.time, run["velocity.x"], {label = "velocity form", color = "vermillion", style = "dashed"})
figure:panel{y = "difference × 10^9"}:stairs(run.time, 1e9 * run.error, {color = "green"})
figure:save("out/figure_5_18." .. format)

figure = pl.figure{title = "A discrete system and its blend of seven models", x = time, height = 170}
outputs = figure:panel{y = "output", height = 1.4}
outputs:stairs(run.time, run.y, {label = "discrete", color = "blue"})
outputs:line(run.time, run["blend.x"], {label = "blended", color = "vermillion", style = "dashed"})
figure:panel{y = "difference"}:stairs(run.time, run.blend_error, {color = "green"})
figure:save("out/figure_5_23." .. format)

print "  k   discrete    blended     expected"
for _, row in ipairs{{1, -1.04670}, {2, 0.10614}, {3, 1.48245}, {10, 0.88353}, {24, 0.18068}} do
  print(("%3d   %9.6f   %9.5f   %9.5f"):format(row[1], run:at("y", row[1]), run:at("blend.x", row[1] + 0.99), row[2]))
end

-- What summed differences do instead: y(k+1) = y(k) + a(y(k)) (y(k) - y(k-1)) + 3 u(k)^2 (u(k) - u(k-1)).
local last, now, u0, worst = 0, 0, 0, 0
for k = 0, 22 do
  local u = run:at("u", k)
  last, now = now, now + (1 - now ^ 2) / (1 + now ^ 2) ^ 2 * (now - last) + 3 * u ^ 2 * (u - u0)
  u0 = u
  worst = math.max(worst, math.abs(now - run:at("y", k + 1)))
end
print(("\nThe velocity form is at most %.0e off, the blend %.4f (expected 0.2339), summed differences %.2g.")
  :format(run:measure("max_abs", "error"), run:measure("max_abs", "blend_error"), worst))
