-- How well do three frozen models, blended by Gaussian weights, stand for a pendulum?
--
-- Figures 5.19 to 5.22 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
-- (2023): the weights, the nonlinearity and its blend, and the motion around pi/4, where the blend is worst.
-- plantloop script scripts/book/pendulum_blend.lua [png|svg]
local pl = require "plantloop"

local format = arg[1] or "png"
local weights = pl.load(pl.project .. "/diagrams/book/pendulum_weights.yaml")
local pendulum = pl.load(pl.project .. "/diagrams/book/pendulum_blend.yaml")
local angle = {label = "angle θ [rad]", limits = {0, pl.pi}}

-- Weights over the angle (figure 5.19).
local over = weights:run()
local figure = pl.figure{title = "Weights of the three models", x = angle, y = "weight μ", limits = {0, 1},
                         height = 110}
for i, look in ipairs{{label = "model at 0", color = "blue"}, {label = "model at π/2", color = "vermillion"},
                      {label = "model at π", color = "green"}} do
  figure:line(over.theta, over["mu." .. i], look)
end
figure:save("out/figure_5_19." .. format)

print "     theta   weights                           expected"
local expected = {{0, ".925341 .074620 .000039"}, {pl.pi/8, ".778515 .221077 .000408"},
                  {pl.pi/4, ".49838 .49838 .003241"}}
for _, row in ipairs(expected) do
  local theta, text = row[1], row[2]
  print(("%10.6f   %.6f %.6f %.6f        %s"):format(theta, over:at("mu.1", theta), over:at("mu.2", theta),
                                                    over:at("mu.3", theta), text))
end

-- The nonlinearity and its blend (figure 5.20).
figure = pl.figure{title = "The nonlinearity of the pendulum and its blend", x = angle, height = 150}
local nonlinearity = figure:panel{y = "factor of −Q dθ/dt", limits = {-1.2, 1.2}, height = 1.6}
nonlinearity:line(over.theta, over.cosine, {label = "cos θ", color = "blue"})
nonlinearity:line(over.theta, over.blended, {label = "blended, μ_1 − μ_3", color = "vermillion", style = "dashed"})
nonlinearity:reference{x = pl.pi/4, label = "π/4"}
figure:panel{y = "difference", limits = {-0.3, 0.3}}:line(over.theta, over.error, {color = "green"})
figure:save("out/figure_5_20." .. format)

print "\n   width   largest difference from the cosine"
local s = pl.range(0.5, 1, 0.01)
local worst = pl.zeros(#s)
for i = 1, #s do worst[i] = weights:run{set = {s = s[i]}}:measure("max_abs", "error") end
local best = worst:argmin()
print(("%8.2f   %.4f   expected 0.2205"):format(0.7, over:measure("max_abs", "error")))
print(("%8.2f   %.4f   expected 0.2167, the least of all widths"):format(s[best], worst[best]))

-- The motion around pi/4 (figures 5.21 and 5.22).
local run = pendulum:run{output_interval = 0.01}
figure = pl.figure{title = "The pendulum and three blended models around π/4",
                   x = {label = "time t [s]", limits = {0, 33}}, height = 180}
local motion = figure:panel{y = "angle θ [rad]", limits = {0.65, 0.95}, lines = {{y = pl.pi/4}}, height = 1.4}
motion:line(run.time, run["original.theta"], {label = "original", color = "blue"})
motion:line(run.time, run["blended.theta"], {label = "blended", color = "vermillion", style = "dashed"})
figure:panel{y = "difference [mrad]", lines = {{y = 0}}}:line(run.time, 1000 * run.error, {color = "green"})
figure:panel{y = "force F [N]", limits = {15, 20}, height = 0.7}:stairs(run.time, run.force, {color = "grey"})
figure:save("out/figure_5_21_5_22." .. format)

print "\n   t [s]   original [rad]   expected   blended [rad]   expected"
local answers = {{3, .852537, .864941}, {8.99, .876355, .920487}, {16.99, .785697, .788186}, {24.99, .701845, .672709},
                 {33, .785149, .783527}}
for _, row in ipairs(answers) do
  local t, original, blended = table.unpack(row)
  print(("%8g   %14.6f   %.6f   %13.6f   %.6f"):format(t, run:at("original.theta", t), original,
                                                     run:at("blended.theta", t), blended))
end
local at = pl.argmax(pl.abs(run.error))
print(("\nThe blend is at most %.4f rad off (expected 0.04496), at %.1f s. Drawn: out/figure_5_19 to 5_22.%s")
  :format(math.abs(run.error[at]), run.time[at], format))
