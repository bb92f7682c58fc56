-- How does the overshoot of the loop depend on the integral gain?
local pl = require "plantloop"

local loop = pl.load(pl.project .. "/diagrams/examples/loop.yaml")
local figure = pl.figure{title = "Step responses", x = "time [s]"}
local responses = figure:panel{y = "y", lines = {{y = 1}}}
local summary = figure:panel{x = "K1", y = "overshoot [%]", limits = {0, 100}}

local gains = {10, 30, 60}
for _, K1 in ipairs(gains) do
  local run = loop:run{set = {["controller.K1"] = K1}, stop = 4}
  responses:line(run.time, run.y, {label = ("K1 = %g"):format(K1)})
end

local K1 = pl.linspace(2, 70, 69)
local overshoot = pl.zeros(#K1)
for i, gain in ipairs(K1) do
  local run = loop:run{set = {["controller.K1"] = gain}, stop = 20}
  overshoot[i] = run:measure("overshoot", "y", {step = {at = 0.5, from = 0, to = 1}})
end
summary:line(K1, overshoot)
figure:save "out/overshoot.png"

local at_ten = pl.interp1(overshoot:slice(overshoot:argmin()), K1:slice(overshoot:argmin()), 10)
print(("It grows with the gain: %.1f %% at K1 = %g, %.1f %% at K1 = %g; 10 %% are reached at K1 = %.1f.")
  :format(overshoot[1], K1[1], overshoot[#overshoot], K1[#K1], at_ten))
