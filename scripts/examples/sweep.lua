-- How far may the response of a loop spread when its plant is known to 15 % only?
local pl = require "plantloop"

local loop = pl.load(pl.project .. "/diagrams/examples/loop.yaml")
local runs = pl.sweep{diagram = loop, draws = 300, seed = 1, stop = 3, output_interval = 0.01,
  random = {["x.tau"] = {"normal", 0.1, 0.015}, ["y.tau"] = {"normal", 1, 0.15}}}

local rows, overshoot = {}, pl.zeros(#runs)
for i, point in ipairs(runs) do
  rows[i] = point.run.y:table()
  overshoot[i] = point.run:measure("overshoot", "y", {step = {at = 0.5, from = 0, to = 1}})
end

local figure = pl.figure{title = "300 loops with uncertain time constants", x = "time [s]"}
figure:panel{y = "output y", lines = {{y = 1}}}:quantile_fan(runs[1].run.time, pl.transpose(pl.matrix(rows)))
figure:panel{x = "overshoot [%]", y = "density", height = 0.7}:histogram(overshoot, {density = true, median = true})
figure:save "out/sweep.png"

-- Every combination of two values is a grid.
local corners = pl.sweep{diagram = loop, stop = 3, grid = {["x.tau"] = {0.085, 0.115}, ["y.tau"] = {0.85, 1.15}}}
local worst = 0
for _, point in ipairs(corners) do
  worst = math.max(worst, point.run:measure("overshoot", "y", {step = {at = 0.5, from = 0, to = 1}}))
end
local sorted = pl.sort(overshoot)
print(("The overshoot lies between %.1f %% and %.1f %% in nine of ten loops; at the corners of one deviation up to %.1f %%.")
  :format(sorted[16], sorted[285], worst))
