-- Which way of blending three PI controllers moves a robot arm in the same way everywhere?
--
-- Figure 6.12 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods (2023). The controllers are
-- designed in one call: each cancels the slow pole of the arm at one of three angles.
-- plantloop script scripts/book/robot.lua [png|svg]
local pl = require "plantloop"

local format = arg[1] or "png"
local arm = pl.load(pl.project .. "/diagrams/book/models/arm.yaml")
local design = {method = "lambda_tuning", controller = "pi", lambda = 0.5}
local points = {{at = 0}, {at = 0.2, diagram = arm:with{phi0 = "36*pi/180"}}, {at = 0.7, diagram = arm:with{phi0 = "72*pi/180"}}}
local path = arm:controller_family{path = "out/robot_controllers.yaml", input = "M", output = "phi", scheduling = "y",
                                   points = points, design = design}
print "        K0          K1   expected"
local expected = {"9.296510, 9.810000", "9.439485, 7.936457", "9.793645, 3.031457"}
for i, point in ipairs(points) do
  local c = pl.tune((point.diagram or arm):linearise{inputs = "M", outputs = "phi"}, design)
  print(("%10.6f  %10.6f   %s"):format(c.kp, c.ki, expected[i]))
end
print(("written to %s, for the block blended_controller\n"):format(path))

local run = pl.load(pl.project .. "/diagrams/book/robot.yaml"):run{output_interval = 0.005}
local figure = pl.figure{title = "Blended in velocity form the arm answers the same way everywhere",
                         x = {label = "time t [s]", limits = {0, 37}}, height = 220}
local height = figure:panel{y = "height y [m]"}
height:stairs(run.time, run.w, {label = "set point", color = "grey", style = "dashed"})
local ways = {{"velocity", "velocity form", "blue"}, {"parameters", "blended parameters or signals", "vermillion"},
              {"single", "one controller", "green"}}
for _, way in ipairs(ways) do height:line(run.time, run[way[1] .. ".y"], {label = way[2], color = way[3]}) end
figure:save("out/figure_6_12." .. format)

print "\n    t   velocity form   expected   parameters   expected"
for _, row in ipairs{{1.5, .077390, .077123}, {7.5, .484889, .450818}, {12.99, .697656, .640677}, {30.99, .696494, .633636}} do
  print(("%6g   %12.6f   %.6f   %10.6f   %.6f"):format(row[1], run:at("velocity.y", row[1]), row[2],
                                                     run:at("parameters.y", row[1]), row[3]))
end
print(("\nSix seconds after the step to 0.7 m the velocity form is %.3f m short, the conventional one %.3f m.")
  :format(0.7 - run:at("velocity.y", 12.99), 0.7 - run:at("parameters.y", 12.99)))
