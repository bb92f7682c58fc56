-- How long is a pendulum, and how much does it lose, by a noisy record of its swing?
local pl = require "plantloop"

local swing = pl.diagram [[
plantloop: 1
parameters: {length: 0.5, damping: 0.1, g: 9.81}
blocks:
  angle: {type: integrator, in: rate, initial: 1.2}
  rate: {type: integrator, in: -g/length*sin(angle) - damping*rate}
  noise: {type: white_noise, deviation: 0.05, rate: 0.05}
  sensor: angle + noise
simulation: {stop: 8}
record: [angle, sensor]
]]

-- What a rig would have measured; the fit does not know these numbers.
local rig = swing:run{set = {length = 0.72, damping = 0.23}, output_interval = 0.05}
local time, measured = rig.time, rig.sensor

local fit = pl.fit{diagram = swing, parameters = {"length", "damping", ["angle.initial"] = 1},
  bounds = {length = {0.1, 3}, damping = {0, 2}}, data = {time = time, angle = measured}}
print(fit.report)

local figure = pl.figure{title = "A swing and the fitted pendulum", x = {label = "time [s]", limits = {0, 8}}}
local panel = figure:panel{y = "angle [rad]"}
panel:scatter(time, measured, {label = "measured"})
panel:line(time, fit.fitted.angle, {label = "fitted"})
figure:panel{y = "left over [rad]", height = 0.5}:stem(time, measured - fit.fitted.angle)
figure:save "out/fit.png"

local length, damping = fit.intervals.length, fit.intervals.damping
print(("%.3f m to %.3f m long, and it loses %.3f 1/s to %.3f 1/s, each with 95 %% confidence.")
  :format(length[1], length[2], damping[1], damping[2]))
