-- Which model describes the process behind a file of measurements?
--
-- plantloop script scripts/examples/identify.lua DATA.csv [NAME]
-- DATA.csv has the columns time, u..., y...; empty cells are missing values. For each output the script looks at the data,
-- tries linear and polynomial structures on the first part, judges each by its free run on what was held back, and writes the
-- best model and the figures of its validation to out/NAME-*. Without a file it identifies a made-up tank.
local pl = require "plantloop"
local identify = pl.identify

-- A tank whose outflow goes with the root of its level, when no file is given.
local function made_up()
  local n = 1200
  local u = identify.staircase{samples = n, hold = {10, 40}, lower = 0.2, upper = 1, seed = 3}
  local y, noise = pl.zeros(n), identify.white_noise{samples = n, deviation = 0.003, seed = 4}
  y[1] = 0.3
  for k = 2, n do y[k] = y[k - 1] + 0.1 * (u[k - 1] - 1.2 * math.sqrt(math.max(y[k - 1], 0))) end
  return identify.data{u = u, y = y + noise, Ts = 1, inputs = {"u_inflow"}, outputs = {"y_level"}}
end

local path = arg[1]
local name = arg[2] or (path and path:match("([^/]+)%.csv$")) or "tank"
local all = path and identify.read(path) or made_up()
print("The data")
for _, line in ipairs(all:advice()) do print("  " .. line) end
if all.missing > 0 then
  all = all:fill("line")
  print "  missing values inside of the record are filled with straight lines"
end

-- One output at a time; the others are left out.
local function data_of(output)
  local parts = {}
  for i = 1, all.experiments do
    local e = all:experiment(i)
    local y = e:column(all.outputs[output])
    parts[i] = identify.data{u = e.u, y = y, Ts = all.Ts, inputs = all.inputs, outputs = {all.outputs[output]}}
  end
  return #parts == 1 and parts[1] or identify.join(table.unpack(parts))
end

-- Free-run error with the first samples not scored. A model that fails is a line in the table, not the end.
local scored_from = 20
local function judge(model, data)
  local ok, y = pcall(function() return model:simulate(data) end)
  if not ok then return math.huge end
  local rmse = identify.metrics(data.y, y, {skip = math.min(scored_from, data.samples // 4)}).RMSE
  return rmse == rmse and rmse or math.huge
end

local function identify_output(output)
  local data = data_of(output)
  local train, held = data:split(0.7)
  local label = all.outputs[output]
  print(("\n%s: %d samples to identify, %d held back"):format(label, train.samples, held.samples))
  local inputs = #all.inputs
  local candidates = {}
  local function try(what, fit)
    local ok, model = pcall(fit, train)
    if not ok then
      print(("  %-58s %s"):format(what, tostring(model):gsub("\n.*", ""):sub(1, 90)))
      return
    end
    local candidate = {what = what, fit = fit, model = model, train = judge(model, train), held = judge(model, held)}
    candidates[#candidates + 1] = candidate
    print(("  %-58s %12.5g %12.5g"):format(what, candidate.train, candidate.held))
  end
  print(("  %-58s %12s %12s"):format("structure", "identified", "held back"))

  -- Linear: orders by a table of ARX structures, then output error around the best.
  local most = train.samples > 600 and 6 or 3
  local ok, list = pcall(identify.order_table, train, {na = {1, most}, nb = {1, most}, delay = {-1, 6}, remove_means = true, validation = held})
  local delay = 0
  if ok and inputs > 0 then
    for _, by in ipairs{"MDL", "simulated"} do
      local c = list.best[by]
      try(("ARX na %d nb %d delay %d, by %s"):format(c.na, c.nb, c.delay, by == "MDL" and by or "free run"),
          function(d) return identify.arx(d, {na = c.na, nb = c.nb, delay = c.delay, remove_means = true}) end)
    end
    delay = list.best.simulated.delay
    for nf = 1, 4 do
      try(("output error nb %d nf %d delay %d"):format(nf, nf, delay),
          function(d) return identify.oe(d, {nb = nf, nf = nf, delay = delay, remove_means = true}) end)
    end
    try("Box-Jenkins nb 2 nc 1 nd 2 nf 2", function(d) return identify.bj(d, {nb = 2, nc = 1, nd = 2, nf = 2, delay = delay, remove_means = true}) end)
    try("state space by subspace", function(d) return identify.state_space(d, {remove_means = true}) end)
  end

  -- Polynomial NARX: lags around those of the linear models, terms by orthogonal least squares, fitted to the free run.
  local function lags(ny, first, last)
    local text = ny > 0 and ("y(k-1..%d)"):format(ny) or ""
    for i = 1, inputs do
      text = text .. (text == "" and "" or ", ") .. ("u%d(k-%d..%d)"):format(i, first, last)
    end
    return text
  end
  for _, ny in ipairs{1, 2, 3, 4} do
    for _, nu in ipairs{2, 4, 6} do
      for _, degree in ipairs{2, 3} do
        local signals = ny + inputs * nu
        if degree == 2 and signals <= 24 or signals <= 8 then
          try(("polynomial NARX, degree %d, %d of y, %d of u"):format(degree, ny, nu), function(d)
            return identify.polynomial(d, {regressors = lags(ny, delay + 1, delay + nu), degree = degree,
                                           most_terms = 30, iterations = 40})
          end)
        end
      end
    end
  end

  local best
  for _, c in ipairs(candidates) do
    if c.held < math.huge and (not best or c.held < best.held) then best = c end
  end
  if not best then
    print "  no structure gives a model that runs freely"
    return
  end
  print(("  best: %s, free run %.5g held back (standard deviation %.5g)"):format(best.what, best.held, pl.std(held.y)))

  -- The best structure again, by all data, is what is saved; the figures judge the one that has not seen what was held back.
  local fitted, final = pcall(best.fit, data)
  if not fitted or judge(final, data) > 1.5 * math.max(best.train, best.held) then
    print "  the fit to all data does not run freely as well: the model of the first part is saved"
    final = best.model
  end
  local stem = ("out/%s-%s"):format(name, label)
  final:save(stem .. ".yaml")
  print(("  written: %s.yaml, %s-validation.png, %s-residuals.png"):format(stem, stem, stem))
  for _, warning in ipairs(final.report.warnings) do print("  warning: " .. warning) end

  local y = best.model:simulate(held)
  local figure = pl.figure{title = best.what .. " on data that it has not seen", x = "time t [s]"}
  figure:panel{y = label}:markers(held.time, held.y, {marker = "dot", color = "grey", label = "measured"})
        :line(held.time, y, {color = "blue", label = "free run"})
  figure:panel{y = "error", height = 0.5}:line(held.time, held.y - y, {color = "vermillion"})
  figure:save(stem .. "-validation.png")

  local has_predictor, predicted = pcall(function() return best.model:predict(held, 1) end)
  local e = held.y - (has_predictor and predicted or y)
  local skip = math.min(scored_from, #e // 4)
  e = e:slice(skip + 1, #e)
  figure = pl.figure{title = has_predictor and "Residuals of one step" or "Residuals of the free run", x = "lag [samples]"}
  local c = identify.autocorrelation(e)
  figure:panel{y = "e with e", limits = {-1, 1}, bands = {{lower = -c.band, upper = c.band}}}:line(c.lag, c.r, {style = "line_points"})
  for i = 1, inputs do
    local cross = identify.cross_correlation(e, held:column(all.inputs[i]):slice(skip + 1, held.samples))
    figure:panel{y = "e with " .. all.inputs[i], limits = {-1, 1}, bands = {{lower = -cross.band, upper = cross.band}}}
          :line(cross.lag, cross.r, {style = "line_points"})
  end
  figure:save(stem .. "-residuals.png")
  if inputs > 0 then
    for _, test in ipairs(identify.residual_tests(e, held:column(all.inputs[1]):slice(skip + 1, held.samples))) do
      print(("  %-14s %s"):format(test.name, test.meaning))
    end
  end
end

for output = 1, #all.outputs do identify_output(output) end
