-- Which records can identification be tried on, when nothing has been measured yet?
--
-- plantloop script scripts/examples/records.lua [FOLDER]
-- Simulates well-known test rigs of system identification from their published equations and writes two files for each,
-- NAME.csv to identify with and NAME-test.csv to judge with, below out/records: the first is meant for identify.lua. The
-- numbers are those of simulation, not the measured records, which their authors publish.
local pl = require "plantloop"
local identify = pl.identify

local folder = arg[1] or "out/records"

-- x after the time h, by the classical Runge-Kutta method in `parts` steps; f writes dx into a table.
local function advance(f, x, u, h, parts)
  local n, dt = #x, h / parts
  local k1, k2, k3, k4, at = {}, {}, {}, {}, {}
  for _ = 1, parts do
    f(x, u, k1)
    for i = 1, n do at[i] = x[i] + dt / 2 * k1[i] end
    f(at, u, k2)
    for i = 1, n do at[i] = x[i] + dt / 2 * k2[i] end
    f(at, u, k3)
    for i = 1, n do at[i] = x[i] + dt * k3[i] end
    f(at, u, k4)
    for i = 1, n do x[i] = x[i] + dt / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]) end
  end
end

local function root(x) return math.sqrt(math.max(x, 0)) end

-- The outputs of a system that is held between samples, with white noise on what is measured.
local function measure(system, u, seed)
  local n = #u
  local y, x = pl.zeros(n), {table.unpack(system.start)}
  local noise = identify.white_noise{samples = n, deviation = system.noise, seed = seed}
  for k = 1, n do
    y[k] = system.output(x, u[k])
    advance(system.slopes, x, u[k], system.Ts, system.parts)
    if system.limit then system.limit(x) end
  end
  return y + noise
end

-- Sines of one amplitude and random phases, with the root mean square `rms`.
local function sum_of_sines(n, first, last, rms, seed)
  local phases = identify.staircase{samples = last, hold = 1, lower = 0, upper = 2 * math.pi, seed = seed}
  local u = pl.zeros(n)
  local t = pl.linspace(0, 2 * math.pi * (n - 1) / n, n)
  for line = first, last do u = u + pl.cos(line * t + phases[line]) end
  return u * (rms / pl.std(u))
end

local systems = {}

-- A second-order circuit with a cubic spring (T. Wigren, J. Schoukens 2013): sines to identify, filtered noise of growing
-- amplitude to test.
do
  local w, damping, cubic = 2 * math.pi * 68, 0.05, 4
  local test = pl.zeros(4000)
  local noise, s1, s2 = identify.white_noise{samples = 4000, deviation = 1, seed = 11}, 0, 0
  for k = 1, 4000 do
    s1 = s1 + 0.7 * (noise[k] - s1)
    s2 = s2 + 0.7 * (s1 - s2)
    test[k] = 0.14 * s2 * k / 4000
  end
  systems[#systems + 1] = {
    name = "silverbox", Ts = 1 / 610.35, parts = 4, start = {0, 0}, noise = 2e-4, input = "u_voltage [V]", output_name = "y_voltage [V]",
    slopes = function(x, u, dx)
      dx[1] = x[2]
      dx[2] = w * w * (u - x[1] - cubic * x[1] ^ 3) - 2 * damping * w * x[2]
    end,
    output = function(x) return x[1] end,
    identify = sum_of_sines(4096, 1, 1342, 0.055, 21), test = test,
  }
end

-- Two tanks below each other; what overflows from the upper one partly falls into the lower one (M. Schoukens, J. Noel 2017).
systems[#systems + 1] = {
  name = "tanks", Ts = 4, parts = 8, start = {5, 5}, noise = 0.05, input = "u_pump [V]", output_name = "y_level [V]",
  slopes = function(x, u, dx)
    local upper, lower = math.min(x[1], 10), math.min(x[2], 10)
    dx[1] = 0.05 * u - 0.08 * root(upper)
    dx[2] = 0.08 * root(upper) - 0.07 * root(lower)
    if x[1] >= 10 and dx[1] > 0 then
      dx[2] = dx[2] + 0.4 * dx[1]
      dx[1] = 0
    end
    if x[2] >= 10 and dx[2] > 0 then dx[2] = 0 end
  end,
  output = function(x) return math.min(x[2], 10) end,
  identify = sum_of_sines(1024, 1, 59, 1.1, 22) + 3.2, test = sum_of_sines(1024, 1, 59, 1.1, 23) + 3.2,
}

-- A mass on a spring with hysteresis (J. Noel, M. Schoukens 2016).
systems[#systems + 1] = {
  name = "bouc_wen", Ts = 1 / 750, parts = 20, start = {0, 0, 0}, noise = 8e-6, input = "u_force [N]", output_name = "y_displacement [m]",
  slopes = function(x, u, dx)
    dx[1] = x[2]
    dx[2] = (u - 10 * x[2] - 5e4 * x[1] - x[3]) / 2
    dx[3] = 5e4 * x[2] - 1e3 * (0.8 * math.abs(x[2]) * x[3] - 1.1 * x[2] * math.abs(x[3]))
  end,
  output = function(x) return x[1] end,
  identify = sum_of_sines(8192, 55, 1638, 50, 24),
  test = identify.chirp{samples = 6000, Ts = 1 / 750, from = 2 * math.pi * 20, to = 2 * math.pi * 50, amplitude = 40},
}

-- A filter, a diode that clips, and a filter (J. Schoukens, J. Suykens, L. Ljung 2009): what is between cannot be seen.
do
  local w1, w2 = 2 * math.pi * 4.4e3, 2 * math.pi * 5e3
  systems[#systems + 1] = {
    name = "wiener_hammerstein", Ts = 1 / 51200, parts = 4, start = {0, 0, 0, 0, 0, 0}, noise = 2e-4, input = "u [V]", output_name = "y [V]",
    slopes = function(x, u, dx)
      dx[1] = w1 * (u - x[1]) * 0.5
      dx[2] = x[3]
      dx[3] = w1 * w1 * (x[1] - x[2]) - 0.5 * w1 * x[3]
      local v = x[2]
      local clipped = v > 0 and v / (1 + 0.9 * v) or v
      dx[4] = x[5]
      dx[5] = w2 * w2 * (clipped - x[4]) - 0.7 * w2 * x[5]
      dx[6] = w2 * 0.6 * (x[4] - x[6])
    end,
    output = function(x) return x[6] end,
    identify = sum_of_sines(10000, 1, 1950, 0.65, 25), test = sum_of_sines(8000, 1, 1560, 0.65, 26),
  }
end

-- Two motors on one belt; only the speed of the pulley between them is known, without its sign (T. Wigren, M. Schoukens 2017).
systems[#systems + 1] = {
  name = "drives", Ts = 0.02, parts = 4, start = {0, 0, 0}, noise = 0.02, input = "u [V]", output_name = "y_speed",
  slopes = function(x, u, dx)
    dx[1] = x[2]
    dx[2] = x[3]
    dx[3] = 4 * 18 * 18 * u * 1.6 - (4 * 18 * 18 * x[1] + (18 * 18 + 2 * 0.25 * 18 * 4) * x[2] + (4 + 2 * 0.25 * 18) * x[3])
  end,
  output = function(x) return math.abs(x[1]) end,
  identify = identify.staircase{samples = 500, hold = {5, 25}, lower = -1.2, upper = 1.4, seed = 13},
  test = identify.staircase{samples = 500, hold = {5, 25}, lower = -1.2, upper = 1.4, seed = 14},
}

-- A stirred tank with an exothermic reaction, cooled by a jacket (J. Morningred et al. 1992).
systems[#systems + 1] = {
  name = "reactor", Ts = 6, parts = 30, start = {0.083, 440}, noise = 3e-4, input = "u_coolant [l/min]", output_name = "y_concentration [mol/l]",
  slopes = function(x, u, dx)
    local rate = 7.2e10 * math.exp(-1e4 / x[2]) * x[1]
    dx[1] = ((1 - x[1]) - rate) / 60
    dx[2] = ((350 - x[2]) + 200 * rate + 0.01 * u * (1 - math.exp(-700 / u)) * (350 - x[2])) / 60
  end,
  output = function(x) return x[1] end,
  identify = identify.staircase{samples = 3000, hold = {15, 60}, lower = 92, upper = 109, seed = 15},
  test = identify.staircase{samples = 2000, hold = {15, 60}, lower = 92, upper = 109, seed = 16},
}

for i, system in ipairs(systems) do
  for number, part in ipairs{"", "-test"} do
    local u = number == 1 and system.identify or system.test
    local y = measure(system, u, 10 * i + number)
    local data = identify.data{u = u, y = y, Ts = system.Ts, inputs = {system.input}, outputs = {system.output_name}}
    data:save(("%s/%s%s.csv"):format(folder, system.name, part))
  end
  print(("%-20s %5d and %5d samples, every %g s"):format(system.name, #system.identify, #system.test, system.Ts))
end
