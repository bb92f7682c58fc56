-- Which implementation of the same scheduled gains still behaves as designed after a large step of the set point?
--
-- Figures 6.7 and 6.8 of J. Kocijan, Modelling Dynamic Systems with Artificial Neural Networks and Related Methods
-- (2023): plant (6.2) with a controller in velocity form, two conventional ones, and one with fixed gains.
-- plantloop script scripts/book/gain_scheduling.lua [png|svg]
local pl = require "plantloop"

local format = arg[1] or "png"
local diagram = pl.load(pl.project .. "/diagrams/book/gain_scheduling.yaml")
local loops = {
  {name = "v", label = "velocity form", color = "blue"},
  {name = "c1", label = "conventional, parallel", color = "vermillion"},
  {name = "c2", label = "conventional, series", color = "green"},
  {name = "c3", label = "fixed gains", color = "purple"},
}
local steps = {0.05, 0.5, 2}
local limits = {{-0.02, 0.08}, {-0.2, 1.2}, {-2, 5}}

-- Of an answer to a step: overshoot in %, last time outside of 2 %, first time at 63.2 %; both in s.
local function answer(run, column, step)
  local s = (run[column] - step.from) / (step.to - step.from)
  local late = pl.greater_equal(run.time, step.at) * pl.less_equal(run.time, step["until"])
  local there = pl.find(late * pl.greater_equal(s, 0.632))
  return {run:measure("overshoot", column, {step = step}), run:measure("settling_time", column, {step = step}),
          #there > 0 and run.time[there[1]] - step.at or pl.inf}
end

local function text(measured)
  local overshoot, settled, rise = table.unpack(measured)
  local settling = settled < pl.inf and ("%5.3f s"):format(settled) or "not yet"
  return ("%6.2f %%   %s   %5.3f s"):format(overshoot, settling, rise)
end

-- Overshoot, settling and rise of the same loops by an independent simulation.
local expected = {
  [0.05] = {v = "0, .680, .183", c1 = "0, .686, .182", c2 = "0, .711, .185 / 0, .686, .188", c3 = "0, .678, .183"},
  [0.5] = {v = "0, .680, .183", c1 = "1.42, .994, .119", c2 = "117, not settled, .116 / 0, .782, .281",
           c3 = "17.2, 1.147, .310"},
  [2] = {v = "0, .680, .183", c1 = ".49, 1.279, .160", c2 = "108, not settled, .159 / 0, 2.58, 1.67",
         c3 = "66.2, not settled, .90 / 71.9, 5.76, .97"},
}

local outputs = pl.figure{title = "Only the velocity form keeps its answer after large steps",
                          x = {label = "time t [s]", limits = {0, 12}}, height = 220}
local signals = pl.figure{title = "What the velocity form asks of the control signal",
                          x = {label = "time t [s]", limits = {1, 2}}, height = 120,
                          y = {label = "control signal u", scale = "log", limits = {0.1, 1000}}}

print "D, loop                      up: overshoot, 2 %, 63 %         down: overshoot, 2 %, 63 %      expected"
for i, D in ipairs(steps) do
  local run = diagram:run{set = {D = D}, output_interval = 0.002}
  local panel = outputs:panel{y = ("output y, D = %g"):format(D), limits = limits[i]}
  local named = i == 1  -- one legend is enough
  panel:stairs(run.time, run.w, {label = named and "set point" or "", color = "grey", style = "dashed"})
  for _, loop in ipairs(loops) do
    panel:line(run.time, run[loop.name .. ".y"], {label = named and loop.label or "", color = loop.color})
  end
  panel:line(run.time, run["v.y"], {color = loops[1].color})  -- once more, on top
  for _, loop in ipairs(loops) do
    local up = answer(run, loop.name .. ".y", {at = 1, ["until"] = 6, from = 0, to = D})
    local down = answer(run, loop.name .. ".y", {at = 6, ["until"] = 12, from = D, to = 0})
    print(("%4g, %-22s  %s   %s   %s"):format(D, loop.label, text(up), text(down), expected[D][loop.name]))
  end
  print(("      velocity form          peak of u %.2f, expected %s; off the design at most %.1g"):format(
    run:measure("max", "v.u"), ({"0.5", "143.58", "874.33"})[i], run:measure("max_abs", "error")))
  signals:line(run.time, run["v.u"], {label = ("D = %g"):format(D), color = ({"sky", "orange", "black"})[i]})
end
outputs:save("out/figure_6_8." .. format)
signals:save("out/figure_6_8_signals." .. format)
print(("\nThe velocity form: y/w is k p/(s^2 + p s + k p) whatever the height of the step. Drawn: out/figure_6_8.%s")
  :format(format))
