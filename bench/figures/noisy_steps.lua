-- How long does the reference figure take: five noisy step responses of 10 000 samples, 1200 x 800 pixels?
local pl = require "plantloop"
local t = pl.linspace(0, 10, 10000)
local figure = pl.figure{title = "Step responses for five dampings, with sensor noise", x = "time t [s]", y = "output y [m]"}
local state = 1
for _, zeta in ipairs{0.1, 0.2, 0.4, 0.7, 0.9} do
  local wd = 2 * (1 - zeta ^ 2) ^ 0.5
  local noise = {}
  for i = 1, #t do
    state = (state * 1664525 + 1013904223) % 4294967296
    noise[i] = 0.06 * (state / 4294967296 - 0.5)
  end
  local y = 1 - pl.exp(-2 * zeta * t) * (pl.cos(wd * t) + 2 * zeta / wd * pl.sin(wd * t)) + pl.vector(noise)
  figure:line(t, y, {label = ("ζ = %g"):format(zeta)})
end
for _, path in ipairs(arg) do figure:save(path) end
