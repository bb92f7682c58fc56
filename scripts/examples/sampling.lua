-- How slowly may the level controller of two tanks sample before its response suffers?
local pl = require "plantloop"

local tanks = pl.load(pl.project .. "/diagrams/examples/tank.yaml")
local times = {2, 20, 40}
local figure = pl.figure{title = "Level control with three sampling times", x = "time [s]"}
local level = figure:panel{y = "level of the second tank [m]"}
local pump = figure:panel{y = "pump [m³/s]", height = 0.7}

-- What a response costs: the area between level and set point.
local function cost(run) return pl.trapz(run.time, pl.abs(run.set_point - run.second)) end

local first = tanks:run{set = {Ts = times[1]}}
level:line(first.time, first.set_point, {label = "set point", style = "dashed", color = "grey"})
for _, Ts in ipairs(times) do
  local run = tanks:run{set = {Ts = Ts}}
  local label = ("Ts = %g s"):format(Ts)
  level:line(run.time, run.second, {label = label})
  pump:signal(run, "pump", {label = label})
end
figure:save "out/sampling.png"

local best = cost(tanks:run{set = {Ts = 1}})
print "   Ts [s]   cost [m s]"
local longest
for _, Ts in ipairs{1, 2, 5, 10, 20, 30, 40} do
  local c = cost(tanks:run{set = {Ts = Ts}})
  print(("%9g %12.2f"):format(Ts, c))
  if c < 1.1 * best then longest = Ts end
end
print(("Up to Ts = %g s the response costs less than a tenth more than with Ts = 1 s."):format(longest))
