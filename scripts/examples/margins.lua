-- How much more gain does a position loop stand before it becomes unstable?
--
-- L(s) = K / (s (s + 1) (0.1 s + 1)). By Routh's criterion the closed loop is stable for K below 1.1 * 1 / 0.1.
local pl = require "plantloop"

local num, den = {4}, {0.1, 1.1, 1, 0}
local figure = pl.figure{title = "Margins of a position loop, K = 4"}
figure:bode(num, den, {from = 0.1, to = 100})
figure:save "out/margins.svg"

local locus = pl.figure{title = "Where the poles go when the gain grows"}
locus:root_locus({1}, den, {gain = num[1]})
locus:save "out/margins_locus.svg"

local limit = den[2] * den[3] / den[1]
print(("stable up to K = %g, a gain margin of %.2f dB. Drawn: out/margins.svg"):format(limit, 20 * math.log(limit / num[1], 10)))
