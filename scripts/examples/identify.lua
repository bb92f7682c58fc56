-- Which model describes the process behind a file of measurements?
--
-- plantloop script scripts/examples/identify.lua DATA.csv [TEST.csv] [NAME] [effort=1] [train=1] [skip=20] [seed=1]
--
-- The files have the columns time, u..., y...; empty cells are missing values. For each output the script looks at the data,
-- fits linear models, polynomials, networks, local models and Gaussian processes to a part of them and judges each by its free
-- run over blocks of time that were held back. The best structure is fitted again to all data of DATA.csv, judged once by
-- TEST.csv, and written to out/NAME-OUTPUT.yaml with the figures of its validation. What it predicts of the test, in free run
-- from the first measured samples, is written to out/NAME-OUTPUT-test.csv.
--
--   test=FILE.csv  says the same as a second file
--   Ts=0.1       s between samples, for files without times
--   inputs=flow,valve outputs=level   the columns, where they are not called u... and y...
--   train=0.5    only the first half of each record in DATA.csv is used; the rest is the test
--   train=5000   only the first 5000 samples are used
--   skip=20      so many samples at the beginning of each record are not scored
--   effort=3     how much is tried: minutes of an idle machine of two cores; 1 is enough for records of some thousand samples
--
-- Of several outputs there is also a model of all together, out/NAME-together.yaml, for those that drive each other.
--
-- A search that is stopped leaves the best model so far in out/NAME-OUTPUT.yaml.
--
-- What is tried depends on the effort and the size of the record, never on the clock, so that a run can be repeated exactly.
-- Without a file it identifies a made-up tank.
local pl = require "plantloop"
local identify = pl.identify

local files, options, columns, given_name, test_file = {}, {effort = 1, train = 1, skip = 20, seed = 1}, {}, nil, nil
for _, word in ipairs(arg) do
  local key, value = word:match("^(%w+)=(.+)$")
  if key == "test" then
    test_file = value
  elseif key == "inputs" or key == "outputs" then
    columns[key] = {}
    for column in value:gmatch("[^,]+") do table.insert(columns[key], column) end
  elseif key == "Ts" and tonumber(value) then
    columns.Ts = tonumber(value)
  elseif key then
    if not options[key] or not tonumber(value) then
      error(("'%s' is no option; there are effort=, train=, skip=, seed= and Ts= with a number, test= with a CSV file, inputs= and outputs= with names of columns"):format(word), 0)
    end
    options[key] = tonumber(value)
  elseif word:find(".", 1, true) then
    files[#files + 1] = word
  else
    given_name = word
  end
end
if test_file then files[#files + 1] = test_file end
if #files > 2 then error(("there are %d files; there is one to identify from and one to test with"):format(#files), 0) end
if not (options.effort > 0) then error(("effort=%g: it is greater than 0"):format(options.effort), 0) end
if not (options.skip >= 0) then error(("skip=%g: a number of samples, 0 or more"):format(options.skip), 0) end
local effort, seed = options.effort, math.floor(options.seed)

-- A tank whose outflow goes with the root of its level, when no file is given.
local function made_up()
  local n = 600
  local u = identify.staircase{samples = n, hold = {10, 40}, lower = 0.2, upper = 1, seed = 3}
  local y, noise = pl.zeros(n), identify.white_noise{samples = n, deviation = 0.003, seed = 4}
  y[1] = 0.3
  for k = 2, n do y[k] = y[k - 1] + 0.1 * (u[k - 1] - 1.2 * math.sqrt(math.max(y[k - 1], 0))) end
  return identify.data{u = u, y = y + noise, Ts = 1, inputs = {"u_inflow"}, outputs = {"y_level"}}
end

-- What cannot be identified ends with the reason alone.
local function read(path)
  local ok, data = pcall(identify.read, path, columns)
  if ok then return data end
  local reason = tostring(data):gsub("\n.*", ""):gsub("^[^\n]-%.lua:%d+: ", "")
  if reason:find("no column 'time'", 1, true) then reason = reason .. ", as in Ts=0.1" end
  if reason:find("say which columns", 1, true) then reason = reason .. ", as in inputs=flow,valve outputs=level" end
  error(reason, 0)
end

-- Of data with filled gaps: the same with the gaps, by which models are judged.
local as_measured = setmetatable({}, {__mode = "k"})

-- A part of an experiment, and the same of what was measured of it.
local function part_of(data, first, last)
  local part, measured = data:part(first, last), as_measured[data]
  if measured then as_measured[part] = measured:part(first, last) end
  return part
end

-- Of each experiment the part in which everything is measured from its first sample to its last, gaps inside filled.
local function filled(data)
  if data.missing == 0 then return data end
  local parts, cut_off = {}, 0
  for i = 1, data.experiments do
    local e = data:experiment(i)
    local first, last = 1, e.samples
    for _, names in ipairs{e.inputs, e.outputs} do
      for _, label in ipairs(names) do
        local x, from, to = e:column(label), 1, e.samples
        while from <= to and x[from] ~= x[from] do from = from + 1 end
        while to > from and x[to] ~= x[to] do to = to - 1 end
        if from > to then error(("'%s' has no values in experiment %d: leave the column out, or the experiment"):format(label, i), 0) end
        first, last = math.max(first, from), math.min(last, to)
      end
    end
    if last > first then parts[#parts + 1] = e:part(first, last) end
    cut_off = cut_off + e.samples - math.max(0, last - first + 1)
  end
  if #parts == 0 then error("no part of the record has values of all its signals", 0) end
  if cut_off > 0 then print(("  %d samples at the ends of the record, where a signal has no values yet or any more, are left out"):format(cut_off)) end
  data = #parts == 1 and parts[1] or identify.join(table.unpack(parts))
  if data.missing == 0 then return data end
  print(("  %d missing values inside of the record are filled with straight lines to identify from; no model is judged by them"):format(data.missing))
  local whole = data:fill("line")
  as_measured[whole] = data
  return whole
end

local name = given_name or (files[1] and files[1]:match("([^/]+)%.[^./]+$")) or "tank"
if not files[1] then effort = math.min(effort, 0.02) end
local all = files[1] and read(files[1]) or made_up()
print("The data")
for _, line in ipairs(all:advice()) do print("  " .. line) end
all = filled(all)
local test
if files[2] then
  test = filled(read(files[2]))
  if math.abs(test.Ts - all.Ts) > 1e-9 * all.Ts then
    error(("the test has a sample each %g s, the data each %g s; resample one of them"):format(test.Ts, all.Ts), 0)
  end
  for _, names in ipairs{"inputs", "outputs"} do
    local have, given = table.concat(all[names], ", "), table.concat(test[names], ", ")
    if have ~= given then error(("the %s of the test are '%s', those of the data '%s'"):format(names, given, have), 0) end
  end
end
if options.train ~= 1 then
  local share = options.train < 1 and options.train or options.train / all.samples
  if not (share > 0 and share < 1) then
    error(("train=%g: a share below 1, or a number of samples below the %d of the record"):format(options.train, all.samples), 0)
  end
  if options.train > 1 and all.experiments > 1 then error("train= takes a share when the record has several experiments", 0) end
  local rest
  if options.train < 1 then
    local first, last = all:split(share)
    if as_measured[all] then as_measured[first], as_measured[last] = as_measured[all]:split(share) end
    all, rest = first, last
  else
    all, rest = part_of(all, 1, math.floor(options.train)), part_of(all, math.floor(options.train) + 1, all.samples)
  end
  test = test or rest
end

-- One output; the others are left out. Gives the experiments one by one.
local function experiments_of(data, output)
  local parts = {}
  for i = 1, data.experiments do
    local e = data:experiment(i)
    local function of(y)
      return identify.data{u = e.u, y = y:column(data.outputs[output]), Ts = data.Ts, inputs = data.inputs, outputs = {data.outputs[output]}}
    end
    parts[i] = of(e)
    if as_measured[data] then as_measured[parts[i]] = of(as_measured[data]:experiment(i)) end
  end
  return parts
end

local function joined(parts)
  if #parts == 1 then return parts[1] end
  local whole, measured, gaps = identify.join(table.unpack(parts)), {}, false
  for i, part in ipairs(parts) do
    measured[i] = as_measured[part] or part
    gaps = gaps or as_measured[part] ~= nil
  end
  if gaps then as_measured[whole] = identify.join(table.unpack(measured)) end
  return whole
end

-- Parts of time as shares of each experiment: a list of {from, until}, as a list of data sets.
local function cut(parts, shares)
  local result = {}
  for _, part in ipairs(parts) do
    for _, share in ipairs(shares) do
      local first, last = math.floor(share[1] * part.samples) + 1, math.floor(share[2] * part.samples)
      if last - first >= 10 then result[#result + 1] = part_of(part, first, last) end
    end
  end
  return result
end

-- Blocks of time that are held back, never single samples, as neighbours know each other. Short records are split several
-- times, so that every block has its turn.
local function splits_of(parts, samples)
  local held
  if samples < 2500 then
    held = {{{0, 0.25}}, {{0.25, 0.5}}, {{0.5, 0.75}}, {{0.75, 1}}}
  else
    held = {{{0.25, 0.4}, {0.85, 1}}}
  end
  local splits = {}
  for i, blocks in ipairs(held) do
    local rest, at = {}, 0
    for _, block in ipairs(blocks) do
      if block[1] > at then rest[#rest + 1] = {at, block[1]} end
      at = block[2]
    end
    if at < 1 then rest[#rest + 1] = {at, 1} end
    local train, back = cut(parts, rest), cut(parts, blocks)
    splits[i] = {train = joined(train), held = joined(back), train_parts = train, held_parts = back}
  end
  return splits
end

local scored_from = math.floor(options.skip)

-- The free run: NARX models begin with the measured samples that they look back to, linear ones with the state that fits the
-- samples that are not scored best; more of what is measured none of them sees.
local has_state = {["linear model"] = true, ["state-space model"] = true, ["neural state-space model"] = true}
local function free_run(model, part)
  if not has_state[getmetatable(model)] then return model:simulate(part) end
  return model:simulate(part, {start = "estimated", samples = math.max(scored_from, 10)})
end

-- What was measured from a sample on, and the free run there; both without the samples that were not.
local function known(part, first, run)
  local y = (as_measured[part] or part).y
  local a, b = {}, {}
  for k = first, part.samples do
    if y[k] == y[k] then a[#a + 1], b[#b + 1] = y[k], run[k] end
  end
  return pl.vector(a), pl.vector(b)
end

-- Root of the mean square of the free run's error over experiments, the first samples of each not scored; the fit in %; and
-- the mean squares of pieces of them.
local function judge(model, parts)
  local square, count, total, sum, pieces = 0, 0, 0, 0, {}
  for _, part in ipairs(parts) do
    local ok, y = pcall(free_run, model, part)
    if not ok then return math.huge, -math.huge, {} end
    local skip = math.min(scored_from, part.samples // 4)
    local measured, run = known(part, skip + 1, y)
    local is_whole, m = pcall(identify.metrics, measured, run)
    if not is_whole then return math.huge, -math.huge, {} end
    square, count = square + m.SE * #measured, count + #measured
    total, sum = total + pl.sum(measured * measured), sum + pl.sum(measured)
    local cuts = math.max(1, math.min(8, #measured // 25))
    for i = 1, cuts do
      local first, last = (i - 1) * #measured // cuts + 1, i * #measured // cuts
      pieces[#pieces + 1] = identify.metrics(measured:slice(first, last), run:slice(first, last)).SE
    end
  end
  local rmse = math.sqrt(square / count)
  if rmse ~= rmse then return math.huge, -math.huge, {} end
  local deviation = math.sqrt(math.max(total / count - (sum / count) ^ 2, 0))
  return rmse, 100 * (1 - rmse / deviation), pieces
end

local function identify_output(output)
  local parts = experiments_of(all, output)
  local data, label, inputs = joined(parts), all.outputs[output], #all.inputs
  local least_value, greatest_value = pl.min(data.y), pl.max(data.y)
  if data.samples < 100 then error(("'%s' has %d samples; a search of structures that holds some of them back needs 100"):format(label, data.samples), 0) end
  if not (greatest_value - least_value > 1e-12 * math.max(math.abs(least_value), math.abs(greatest_value))) then
    print(("\n'%s' stays at %.6g: there is nothing to identify, its model is that number"):format(label, least_value))
    return nil
  end
  -- Structures of long records are searched on pieces of them; the winner is fitted to everything.
  local most = math.floor(6000 * math.max(0.5, math.min(effort, 4)))
  local searched = parts
  if data.samples > 1.5 * most then
    local keep = most / data.samples / 4
    searched = cut(parts, {{0.05, 0.05 + keep}, {0.35, 0.35 + keep}, {0.65, 0.65 + keep}, {1 - keep, 1}})
  end
  local samples = joined(searched).samples
  local splits = splits_of(searched, samples)
  print(("\n%s: %d samples, structures are searched on %d of them in %d split%s of train and held-back blocks"):format(label, data.samples,
    samples, #splits, #splits > 1 and "s" or ""))

  -- The work that was done, in units of about half a second; what would go beyond the budget is not begun.
  local budget, spent = 250 * effort, 0
  local rows = splits[1].train.samples * #splits

  local candidates, best_so_far = {}, math.huge
  -- fit(data): a model. again(data, model): that model fitted on to more data, where that is cheaper or better.
  local function try(family, what, work, fit, again)
    if spent + work > budget and #candidates > 6 then return end
    spent = spent + work
    local squares, trains, models, pieces = 0, 0, {}, {}
    for i, split in ipairs(splits) do
      local ok, model = pcall(fit, split.train)
      if not ok then
        if i == 1 then print(("  %-62s %s"):format(what, tostring(model):gsub("\n.*", ""):gsub("^.-:%d+: ", ""):sub(1, 70))) end
        return
      end
      models[i] = model
      local rmse, _, own = judge(model, split.held_parts)
      squares = squares + rmse ^ 2
      table.move(own, 1, #own, #pieces + 1, pieces)
      trains = trains + judge(model, split.train_parts) ^ 2
      if squares == math.huge then break end
    end
    local candidate = {family = family, what = what, fit = fit, again = again, models = models, pieces = pieces,
                       parameters = family == "Gaussian process" and 1000 or models[1].report.parameters, train = math.sqrt(trains / #splits),
                       held = math.sqrt(squares / #splits)}
    candidates[#candidates + 1] = candidate
    print(("  %-62s %12.5g %12.5g"):format(what, candidate.train, candidate.held))
    -- Whoever stops the search keeps the best so far.
    if candidate.held < best_so_far then
      best_so_far = candidate.held
      models[1]:save(("out/%s-%s.yaml"):format(name, label))
    end
    return candidate
  end
  print(("  %-62s %12s %12s"):format("structure, and the RMSE of its free run", "identified", "held back"))

  -- Linear: orders and delay by a table of ARX structures, then output error around the best.
  local highest = samples >= 250 and 6 or 3
  local delay, order, best_arx = 0, 2, {}
  -- How many samples later than `delay` each input begins to act.
  local later = {}
  for i = 1, inputs do later[i] = 0 end
  local function delays(d)
    local list = {}
    for i = 1, inputs do list[i] = d + later[i] end
    return list
  end
  if inputs > 0 then
    -- Delays of any length by small models: the least that is not clearly worse than the best, as above.
    local far, long = math.min(60, splits[1].train.samples // 25), -1
    local found, first = pcall(identify.order_table, splits[1].train,
                               {na = {1, 2}, nb = {1, 2}, delay = {-1, far}, offset = true, validation = splits[1].held})
    if found then
      long = first.best.simulated.delay
      for _, c in ipairs(first) do
        if c.simulated < 1.03 * first.best.simulated.simulated then long = math.min(long, c.delay) end
      end
    end
    if long > 4 then
      local ran, d, rmse = pcall(identify.delay_table, splits[1].train, {order = 2, delay = {math.max(-1, long - 10), long + 10}, offset = true})
      if ran then
        local least = pl.min(rmse)
        for i = #d, 1, -1 do
          if rmse[i] < 1.03 * least then long = math.floor(d[i]) end
        end
      end
    end
    -- Inputs that act later than the others, one after the other.
    if inputs > 1 and found then
      delay = math.max(long, 0)
      local function error_of(list)
        local ok, model = pcall(identify.oe, splits[1].train, {nb = 2, nf = 2, delay = list, offset = true, iterations = 15})
        return ok and (judge(model, splits[1].held_parts)) or math.huge
      end
      local now = delays(delay)
      local least = error_of(now)
      for i = 1, inputs do
        local start = now[i]
        for _, d in ipairs{-1, 0, 1, 2, 3, 5, 8, 12, 17, 23, 30, 40} do
          local list = {table.unpack(now)}
          list[i] = d
          local e = d <= far and d ~= start and error_of(list) or math.huge
          if e < 0.9 * least then now, least = list, e end
        end
      end
      long = math.min(table.unpack(now))
      for i = 1, inputs do later[i] = now[i] - long end
    end
    local range = long > 4 and {long - 2, long + 3} or {-1, 6}
    if math.max(table.unpack(later)) > 0 then range = {long, long} end
    local ok, list = pcall(identify.order_table, splits[1].train,
                           {na = {1, highest}, nb = {1, highest}, delay = range, offset = true, validation = splits[1].held})
    if ok then
      for _, by in ipairs{"MDL", "simulated"} do
        local c = list.best[by]
        best_arx[#best_arx + 1] = c
        try("ARX", ("ARX na %d nb %d delay %d, by %s"):format(c.na, c.nb, c.delay, by == "MDL" and by or "free run"), 0.1,
            function(d) return identify.arx(d, {na = c.na, nb = c.nb, delay = delays(c.delay), offset = true}) end)
      end
      -- The least delay that is not clearly worse than the best: a slow process does not tell where its delay ends.
      delay = list.best.simulated.delay
      for _, c in ipairs(list) do
        if c.simulated < 1.05 * list.best.simulated.simulated then delay = math.min(delay, c.delay) end
      end
    end
    local best_oe
    local ds = delay > 1 and {delay, delay - 1, 0} or delay >= 0 and {delay, delay - 1} or {delay, 0}
    for _, d in ipairs(ds) do
      for nf = 1, highest > 3 and 6 or 4 do
        local c = try("output error", ("output error nb %d nf %d delay %d"):format(nf, nf, d), rows * nf * 2e-5,
            function(x) return identify.oe(x, {nb = nf, nf = nf, delay = delays(d), offset = true}) end)
        if c and (not best_oe or c.held < 0.98 * best_oe.held) then best_oe, delay, order = c, d, nf end
      end
    end
    try("Box-Jenkins", ("Box-Jenkins nb %d nc 1 nd 2 nf %d delay %d"):format(order, order, delay), rows * 1e-4,
        function(d) return identify.bj(d, {nb = order, nc = 1, nd = 2, nf = order, delay = delays(delay), offset = true}) end)
    for n = 1, highest do
      try("state space", ("state space of order %d by subspace"):format(n), rows * 1e-4,
          function(d) return identify.state_space(d, {order = n, offset = true}) end)
    end
  end

  local function delay_words(d)
    if inputs < 2 then return ("delay %d"):format(d) end
    return "delays " .. table.concat(delays(d), ", ")
  end

  -- Lags: ny of the output, nu of each input from the delay on.
  local function channel(i) return all.inputs[i]:match("^[%a_][%w_]*$") or "u" .. i end
  local function lags(ny, nu, d)
    local text = ny > 0 and ("y(k-1..%d)"):format(ny) or ""
    for i = 1, inputs do
      local from = d + later[i]
      text = text .. (text == "" and "" or ", ") ..
             (from < 0 and ("%s(k..%d)"):format(channel(i), nu - 1) or ("%s(k-%d..%d)"):format(channel(i), from + 1, from + nu))
    end
    return text
  end
  local function named(ny, nu, d)
    return inputs == 0 and ("%d of y"):format(ny) or ("%d of y, %d of u, %s"):format(ny, nu, delay_words(d))
  end
  -- The structures that did best so far, for the costly ones to begin with.
  local structures = {}
  local function note(candidate, ny, nu, d)
    if not candidate or candidate.held == math.huge then return end
    structures[#structures + 1] = {ny = ny, nu = nu, d = d, held = candidate.held}
  end
  local function best_structures(count)
    table.sort(structures, function(a, b)
      if a.held ~= b.held then return a.held < b.held end
      return a.ny + a.nu < b.ny + b.nu
    end)
    local seen, chosen = {}, {}
    for _, s in ipairs(structures) do
      local key = s.ny .. " " .. s.nu .. " " .. s.d
      if not seen[key] and #chosen < count then
        seen[key] = true
        chosen[#chosen + 1] = s
      end
    end
    return chosen
  end

  -- What a linear model takes for a delay of one input may be something nonlinear: it stays if a polynomial agrees.
  if inputs > 1 and math.max(table.unpack(later)) > 0 then
    local function error_with(list, d)
      local kept = later
      later = list
      local ok, model = pcall(identify.polynomial, splits[1].train, {regressors = lags(2, 2, d), degree = 2, most_terms = 20, iterations = 15})
      later = kept
      return ok and (judge(model, splits[1].held_parts)) or math.huge
    end
    local none = {}
    for i = 1, inputs do none[i] = 0 end
    for _, d in ipairs{0, 1} do
      if error_with(none, d) < error_with(later, delay) then later, delay = none, d end
    end
  end

  -- The means of a record that does not begin and end at rest are no operating point: a constant that is estimated is better.
  for i, c in ipairs(best_arx) do
    try("ARX with a constant", ("ARX with a constant, na %d nb %d delay %d, by %s"):format(c.na, c.nb, c.delay, i == 1 and "MDL" or "free run"), 0.1,
        function(x) return identify.regression(x, {regressors = lags(c.na, c.nb, c.delay) .. ", 1", normalise = true}) end)
  end

  -- Polynomial NARX: terms by orthogonal least squares, each size fitted to the free run.
  local tried = {}
  local function try_polynomial(ny, nu, d, degree, is_long)
    if inputs == 0 then nu, d = 0, 0 end
    local key = table.concat({ny, nu, d, degree}, " ")
    local signals = ny + inputs * nu
    if ny < 1 or nu < math.min(1, inputs) or tried[key] or signals > ({40, 20, 9})[degree] then return end
    tried[key] = true
    local candidate = try("polynomial NARX", ("polynomial NARX, degree %d, %s"):format(degree, named(ny, nu, d)),
        rows * (is_long and 4e-4 or 1e-4), function(x)
          return identify.polynomial(x, {regressors = lags(ny, nu, d), degree = degree, most_terms = 30, iterations = 30})
        end, function(x, model) return model:fit_free_run(x, 60) end)
    if not is_long then note(candidate, ny, nu, d) end
    return candidate
  end
  for _, degree in ipairs{1, 2, 3} do
    for _, ny in ipairs{order, 2, 1, 3, 4} do try_polynomial(ny, math.max(1, math.min(ny, 4)), delay, degree) end
  end
  for _ = 1, 2 do
    local top = best_structures(1)[1]
    if top then
      for _, degree in ipairs{3, 2} do
        try_polynomial(top.ny, top.nu + 1, top.d, degree)
        try_polynomial(top.ny + 1, top.nu, top.d, degree)
        try_polynomial(top.ny + 1, top.nu + 1, top.d, degree)
        try_polynomial(top.ny, top.nu - 1, top.d, degree)
        try_polynomial(top.ny, top.nu + 2, top.d, degree)
        if top.d > -1 then try_polynomial(top.ny, top.nu + 1, top.d - 1, degree) end
      end
    end
  end

  -- What cannot be seen in a few outputs, as the sign of a speed that is measured without it, is in a long past of the
  -- inputs. Others take such structures only from a polynomial that is clearly better with them.
  if inputs == 1 then
    local short = best_structures(1)[1]
    local limit, found = short and short.held or math.huge, nil
    for _, nu in ipairs{8, 12, 18} do
      local least = math.huge
      for ny = 1, 2 do
        local own = #data.y > 12 * nu and try_polynomial(ny, nu, delay, 2, true)
        if own then
          least = math.min(least, own.held)
          if own.held < 0.9 * limit and (not found or own.held < found.candidate.held) then found = {candidate = own, ny = ny, nu = nu} end
        end
      end
      if least > 1.2 * limit and limit < 0.3 * pl.std(data.y) then break end
    end
    if found then note(found.candidate, found.ny, found.nu, delay) end
  end

  -- Networks beside a linear model, trained through time: first over short pieces, then over the whole record.
  -- The weight decay is that of a priori weights of about 1 and errors as those of the best polynomial.
  local best_network
  local function try_network(s, neurons, decay, thorough)
    local key = table.concat({"network", s.ny, s.nu, s.d, neurons, ("%.1g"):format(decay), thorough and 1 or 0}, " ")
    local signals = s.ny + inputs * s.nu
    if tried[key] or s.ny < 1 or signals > 40 then return end
    tried[key] = true
    local starts, refined, iterations = 6, 2, 60
    if thorough then starts, refined, iterations = 16, 6, 150 end
    local work = rows * (2 + 1e-3 * (neurons * (signals + 2)) ^ 2) * 1e-4 * refined / 2 * iterations / 60
    local candidate = try("network", ("network of %d neurons, %s, decay %.1g%s"):format(neurons, named(s.ny, s.nu, s.d), decay,
                                                                                      thorough and ", long" or ""), work,
      function(x)
        return identify.mlp(x, {regressors = lags(s.ny, s.nu, s.d), hidden = neurons, direct = true, simulation = true, starts = starts,
                                refined = refined, one_step_iterations = 20, iterations = iterations,
                                horizons = {20 + 4 * (s.ny + s.nu), 0}, decay = decay, seed = seed})
      end, function(x, model) return model:fit_free_run(x, {iterations = 60, decay = decay}) end)
    note(candidate, s.ny, s.nu, s.d)
    if candidate and candidate.held < math.huge and (not best_network or candidate.held < best_network.held) then
      best_network = candidate
      candidate.structure, candidate.neurons, candidate.decay = s, neurons, decay
    end
    return candidate
  end
  local deviation = pl.std(data.y)
  local tops = best_structures(2)
  local decay = 1e-2
  if tops[1] then decay = math.max(1e-6, math.min(0.3, (tops[1].held / deviation) ^ 2)) end
  local known = {}
  for _, s in ipairs(tops) do known[s.ny .. " " .. s.nu .. " " .. s.d] = true end
  for _, n in ipairs{order, 3, 2, 4} do
    if not known[n .. " " .. n .. " " .. delay] then
      known[n .. " " .. n .. " " .. delay] = true
      tops[#tops + 1] = {ny = n, nu = inputs > 0 and n or 0, d = delay}
    end
  end
  for _, s in ipairs(tops) do
    local last
    for _, neurons in ipairs{3, 6, 12, 20} do
      local candidate = try_network(s, neurons, decay)
      if last and candidate and candidate.held > 1.05 * last.held then break end
      if candidate and best_network and candidate.held > 1.5 * best_network.held then break end
      last = candidate or last
    end
  end
  -- Around the best one: decay, lags, then more starts and iterations.
  if best_network then
    for _, factor in ipairs{0.1, 10} do
      local last, own = best_network, decay * factor
      while own < 10 and own > 1e-9 do
        local candidate = try_network(last.structure or best_network.structure, last.neurons or best_network.neurons, own)
        if not candidate or candidate.held > last.held then break end
        last, own = candidate, own * factor
      end
    end
    for _ = 1, 3 do
      local before = best_network
      local s, neurons = before.structure, before.neurons
      try_network({ny = s.ny + 1, nu = s.nu, d = s.d}, neurons, before.decay)
      if inputs > 0 then
        try_network({ny = s.ny, nu = s.nu + 1, d = s.d}, neurons, before.decay)
        try_network({ny = s.ny + 1, nu = s.nu + 1, d = s.d}, neurons, before.decay)
        try_network({ny = s.ny - 1, nu = s.nu, d = s.d}, neurons, before.decay)
      end
      if best_network == before then break end
    end
    try_network(best_network.structure, best_network.neurons, best_network.decay, true)
  end

  -- State-space models with neurons. What a network of past outputs finds hard is easy for them: a speed whose sign is
  -- not measured, dynamics after a nonlinearity, integrators.
  local best_neural
  local neural_budget = spent + budget
  local function try_neural(s, thorough)
    if s.order < 1 or s.order > 8 or s.hidden > 24 or s.decay > 10 or s.decay < 1e-7 then return end
    local key = ("neural %d %d %d %d %s %d %.1g %s"):format(s.order, s.hidden, s.out, s.projections, s.integrating, s.d, s.decay, thorough)
    if tried[key] then return end
    tried[key] = true
    local starts, refined, iterations = 6, 2, 50
    if s.projections > 0 then starts, refined = 24, 6 end
    if thorough then starts, refined, iterations = 2 * starts, 2 * refined, 150 end
    local all = s.order + inputs
    local parameters = s.hidden * (all + 1) + s.order * (s.hidden + all + 1) + s.out * (all + 2) + s.order + 1
    local function work_of() return rows * (parameters ^ 2 * 3e-10 + 1e-6) * (15 * starts + refined * iterations) end
    -- Short records allow more.
    local more = math.max(1, math.min(4, math.floor(4 * math.min(1, effort) / work_of())))
    if s.projections > 0 then starts, refined = more * starts, more * refined end
    iterations = more * iterations
    local work = work_of()
    if spent + work > neural_budget then return end
    local list = delays(s.d)
    for i = 1, inputs do list[i] = math.max(0, list[i]) end
    local kept = budget
    budget = neural_budget
    local what = s.hidden + s.out == 0 and ("linear state space of order %d%s, %s"):format(s.order, s.integrating and ", integrating" or "", delay_words(s.d)) or
      ("state space of order %d%s%s%s, %s, decay %.1g%s"):format(s.order, s.integrating and ", integrating" or "",
      s.hidden > 0 and (", %d neurons"):format(s.hidden) or "",
      s.out > 0 and (", %d of the output%s"):format(s.out, s.projections > 0 and ", Wiener" or "") or "", delay_words(s.d), s.decay, thorough and ", long" or "")
    local candidate = try("neural state space", what, work, function(x)
      return identify.neural_state_space(as_measured[x] or x, {order = s.order, hidden = s.hidden, output_hidden = s.out, projections = s.projections,
        integrating = s.integrating, feedthrough = s.d < 0, delay = list, decay = s.decay, starts = starts, refined = refined,
        iterations = iterations, seed = seed})
    end, function(x, model)
      return model:fit_free_run(as_measured[x] or x, {iterations = x.samples < 3000 and 400 or 150, decay = s.decay})
    end)
    budget = kept
    if candidate and candidate.held < math.huge and (not best_neural or candidate.held < best_neural.held) then
      best_neural = candidate
      candidate.neural = s
    end
    return candidate
  end
  local function changed(s, changes)
    local other = {}
    for key, value in pairs(s) do other[key] = value end
    for key, value in pairs(changes) do other[key] = value end
    return other
  end
  if inputs > 0 then
    local plain = {order = order, hidden = 5, out = 0, projections = 0, integrating = false, d = delay, decay = math.min(decay, 1e-2)}
    local wiener = changed(plain, {hidden = 0, out = 6, projections = 1})
    for _, d in ipairs(delay > 0 and {delay, 0} or {delay}) do
      for n = 1, highest do try_neural(changed(plain, {order = n, d = d, hidden = 0})) end
      for n = math.max(1, order - 1), order + 1 do
        try_neural(changed(plain, {order = n, d = d}))
        try_neural(changed(wiener, {order = n, d = d}))
      end
      for n = 2, 3 do try_neural(changed(plain, {order = n, d = d, hidden = 3, integrating = true})) end
    end
    try_neural(changed(plain, {order = order + 1, hidden = 6, out = 4}))
    for _ = 1, 6 do
      local before = best_neural
      if not before then break end
      local s = before.neural
      try_neural(changed(s, {order = s.order + 1}))
      try_neural(changed(s, {order = s.order - 1}))
      if s.hidden > 0 then
        try_neural(changed(s, {hidden = math.ceil(1.5 * s.hidden)}))
        try_neural(changed(s, {hidden = s.hidden // 1.6}))
      else
        try_neural(changed(s, {hidden = 4}))
      end
      if s.out > 0 then
        try_neural(changed(s, {out = math.ceil(1.5 * s.out)}))
      elseif not s.integrating then
        try_neural(changed(s, {out = 4}))
      end
      try_neural(changed(s, {decay = s.decay / 10}))
      try_neural(changed(s, {decay = s.decay * 10}))
      if s.d > 0 then try_neural(changed(s, {d = s.d - 1})) end
      if best_neural == before then break end
    end
    if best_neural then try_neural(best_neural.neural, true) end
  end

  -- One-step models: Gaussian processes, radial functions, local models.
  local function one_step(family, what, work, s, fit)
    try(family, ("%s, %s"):format(what, named(s.ny, s.nu, s.d)), work, function(x) return fit(x, lags(s.ny, s.nu, s.d)) end)
  end
  for i, s in ipairs(best_structures(2)) do
    local points = math.min(math.floor(250 * math.max(1, math.min(effort, 4))), rows)
    one_step("Gaussian process", ("Gaussian process, %d points"):format(points), #splits * (points / 250) ^ 3, s, function(x, regressors)
      return identify.gaussian_process(x, {regressors = regressors, covariance = "se_ard", mean = "linear", starts = 2, iterations = 60,
                                           points = points, seed = seed})
    end)
    for _, models in ipairs{4, 10, 20} do
      one_step("local models", ("%d local models"):format(models), rows * models * 1e-5, s, function(x, regressors)
        return identify.local_models(x, {regressors = regressors, models = models})
      end)
    end
    if i == 1 then
      for _, functions in ipairs{15, 40} do
        one_step("radial functions", ("%d radial functions"):format(functions), #splits * functions * math.min(rows / #splits, 2000) * rows / #splits * 2e-8, s, function(x, regressors)
          return identify.rbf_network(x, {regressors = regressors, functions = functions, width = 0.7})
        end)
      end
    end
  end

  local tests = test and experiments_of(test, output)

  -- A model must bear inputs that go somewhat beyond those it was made from, as its user's may: by a fifth, and the same
  -- backwards in time. It must also bear the inputs of the test, whose outputs it does not see but for the first.
  local means = {}
  for i = 1, inputs do means[i] = pl.mean(data:column(all.inputs[i])) end
  local lowest, greatest = pl.min(data.y), pl.max(data.y)
  local stressed = {}
  local function stress(part, backwards)
    local columns, rows = {}, {}
    for j = 1, inputs do columns[j] = (part:column(all.inputs[j]) - means[j]) * 1.2 + means[j] end
    for k = 1, part.samples do
      rows[k] = {}
      for j = 1, inputs do rows[k][j] = columns[j][backwards and part.samples + 1 - k or k] end
    end
    stressed[#stressed + 1] = {
      part = identify.data{u = pl.matrix(rows), y = part.y, Ts = part.Ts, inputs = all.inputs, outputs = {label}},
      why = backwards and "when its inputs are 20 % larger and backwards in time" or "when its inputs are 20 % larger"}
  end
  -- The output of what integrates goes anywhere with other inputs.
  local integrates = best_neural and best_neural.neural.integrating
  for _, c in ipairs(candidates) do integrates = integrates and c.held >= best_neural.held end
  for _, part in ipairs(parts) do
    if inputs == 0 then
      stressed[#stressed + 1] = {part = part, why = "on the data themselves"}
    elseif not integrates then
      stress(part, false)
      stress(part, true)
    end
  end
  -- Inputs of the test that are no larger than those that are known give no output far beyond those that are known.
  local calm = #stressed
  local within = true
  for _, part in ipairs(tests or {}) do
    stressed[#stressed + 1] = {part = part, why = "on the inputs of the test"}
    for j = 1, inputs do
      local known, new = data:column(all.inputs[j]), part:column(all.inputs[j])
      local margin = 0.05 * (pl.max(known) - pl.min(known))
      within = within and pl.min(new) > pl.min(known) - margin and pl.max(new) < pl.max(known) + margin
    end
  end
  local function bears(model)
    for i, trial in ipairs(stressed) do
      local ok, y = pcall(free_run, model, trial.part)
      local room = (i > calm and within and 0.5 or 2) * (greatest - lowest)
      if not ok or not (pl.min(y) > lowest - room and pl.max(y) < greatest + room) then
        return false, trial.why
      end
    end
    return true
  end
  table.sort(candidates, function(a, b) return a.held < b.held end)
  local best, judged_to_bear = nil, {}
  local function fit_to_use(c)
    if judged_to_bear[c] == nil then
      judged_to_bear[c] = false
      if c.held < math.huge then judged_to_bear[c], c.why = bears(c.models[1]) end
    end
    return judged_to_bear[c]
  end
  for _, c in ipairs(candidates) do
    if not best and c.held < math.huge then
      if fit_to_use(c) then
        best = c
      else
        print(("\n  %s is not taken: it runs away %s"):format(c.what, c.why))
      end
    end
  end
  best = best or candidates[1]
  if not best or best.held == math.huge then
    print "  no structure gives a model that runs freely"
    return {held = math.huge, ny = 2, nu = 2, delay = delay, later = later}
  end
  print(("\n  least error: %s, free run %.5g held back, %.2f %% of the standard deviation"):format(best.what, best.held, 100 * best.held / deviation))
  if best.held > 0.95 * deviation then print "  that is hardly better than the mean of the output: the inputs do not explain it" end
  -- Of models that cannot be told apart one with clearly fewer parameters: their mean squares, piece by piece of the blocks
  -- held back, differ from the best by no more than chance makes in one case of twenty.
  local least = best
  for _, c in ipairs(candidates) do
    if c.held < 1.05 * least.held and #c.pieces == #least.pieces and c.parameters < 0.8 * best.parameters then
      local d = pl.vector(c.pieces) - pl.vector(least.pieces)
      if pl.mean(d) < 1.64 * pl.std(d) / math.sqrt(#d) and fit_to_use(c) then best = c end
    end
  end
  if best ~= least then print(("  not to be told apart from it, with %d parameters instead of %d: %s"):format(best.parameters, least.parameters, best.what)) end

  -- The best structure again, by all data: from the beginning, and on from what a part of them gave. Models that do not bear
  -- what is asked above come last.
  local final, reached, final_bears = nil, math.huge, false
  local function offer(fit, ...)
    local ok, model = pcall(fit, data, ...)
    local rmse = ok and judge(model, parts) or math.huge
    if rmse == math.huge then return end
    local good = bears(model)
    if good == final_bears and rmse < reached or good and not final_bears then final, reached, final_bears = model, rmse, good end
  end
  if not best.again or data.samples < 2 * most then offer(best.fit) end
  if best.again then
    for _, model in ipairs(best.models) do offer(best.again, model) end
  end
  if not final or reached > 1.5 * math.max(best.train, best.held) or not final_bears and fit_to_use(best) then
    print "  the fit to all data does not run freely as well: a model of a part of them is saved"
    final = best.models[1]
    reached = judge(final, parts)
  end

  print(("  %-62s %12s %12s%s"):format("the best of each family: RMSE of the free run", "identified", "held back", tests and "         test" or ""))
  local seen = {}
  for _, c in ipairs(candidates) do
    if not seen[c.family] and c.held < math.huge then
      seen[c.family] = true
      print(("  %-62s %12.5g %12.5g%s"):format(c.what, c.train, c.held, tests and (" %12.5g"):format((judge(c.models[1], tests))) or ""))
    end
  end
  local stem = ("out/%s-%s"):format(name, label)
  final:save(stem .. ".yaml")
  local _, percent = judge(final, parts)
  print(("  the model that is saved, fitted to all data: RMSE %.5g, FIT %.2f %%"):format(reached, percent))
  if tests then print(("  its free run over the test: RMSE %.5g, FIT %.2f %%"):format(judge(final, tests))) end
  for i, part in ipairs(tests or {}) do
    local path = ("%s-test%s.csv"):format(stem, #tests > 1 and i or "")
    local _, run = pcall(free_run, final, part)
    if type(run) == "string" or not (pl.max(pl.abs(run)) < math.huge) then
      print "  its free run over the test runs away: no file of it is written"
      break
    end
    local columns = {}
    local y = (as_measured[part] or part).y
    for k = 1, part.samples do columns[k] = {y[k], run[k], y[k] - run[k]} end
    identify.data{u = part.u, y = pl.matrix(columns), Ts = part.Ts, inputs = all.inputs, outputs = {label, "free_run", "error"}}:save(path)
    print(("  the free run over the test, beside what was measured: %s"):format(path))
  end
  print(("  written: %s.yaml, %s-validation.png, %s-residuals.png"):format(stem, stem, stem))
  local linear = {ARX = true, ["output error"] = true, ["Box-Jenkins"] = true, ["state space"] = true}
  local block = linear[best.family] and "linear_model" or best.family == "neural state space" and "neural_state_space" or "narx"
  print(("  in a diagram: {type: %s, model: %s.yaml}"):format(block, stem))
  for _, warning in ipairs(final.report.warnings) do print("  warning: " .. warning) end

  -- The figures judge what the shown model has not seen.
  local judged = tests and tests[1] or splits[1].held_parts[#splits[1].held_parts]
  local model = tests and final or best.models[1]
  local y = free_run(model, judged)
  local figure = pl.figure{title = best.what .. (tests and ": the test" or ": data that it has not seen"), x = "time t [s]"}
  figure:panel{y = label}:markers(judged.time, (as_measured[judged] or judged).y, {marker = "dot", color = "grey", label = "measured"})
        :line(judged.time, y, {color = "blue", label = "free run"})
  figure:panel{y = "error", height = 0.5}:line(judged.time, judged.y - y, {color = "vermillion"})
  figure:save(stem .. "-validation.png")

  local has_predictor, predicted = pcall(function() return model:predict(judged, 1) end)
  local e = judged.y - (has_predictor and predicted or y)
  local skip = math.min(scored_from, #e // 4)
  e = e:slice(skip + 1, #e)
  figure = pl.figure{title = has_predictor and "Residuals of one step" or "Residuals of the free run", x = "lag [samples]"}
  local c = identify.autocorrelation(e)
  figure:panel{y = "e with e", limits = {-1, 1}, bands = {{lower = -c.band, upper = c.band}}}:line(c.lag, c.r, {style = "line_points"})
  for i = 1, inputs do
    local cross = identify.cross_correlation(e, judged:column(all.inputs[i]):slice(skip + 1, judged.samples))
    figure:panel{y = "e with " .. all.inputs[i], limits = {-1, 1}, bands = {{lower = -cross.band, upper = cross.band}}}
          :line(cross.lag, cross.r, {style = "line_points"})
  end
  figure:save(stem .. "-residuals.png")
  if inputs > 0 then
    for _, result in ipairs(identify.residual_tests(e, judged:column(all.inputs[1]):slice(skip + 1, judged.samples))) do
      print(("  %-14s %s"):format(result.name, result.meaning))
    end
  end
  local top = best_structures(1)[1] or {ny = 2, nu = 2, d = delay}
  return {held = best.held, what = best.what, ny = top.ny, nu = math.max(1, top.nu), delay = top.d, later = later,
          test = tests and (judge(final, tests))}
end

-- Root of the mean square of each output's error in free run, and the mean of their squares in variances.
local function judge_jointly(model, parts, deviations)
  local errors, mean = {}, 0
  for o in ipairs(all.outputs) do
    local square, count = 0, 0
    for _, part in ipairs(parts) do
      local ok, y = pcall(free_run, model, part)
      if not ok then return nil, math.huge end
      local skip = math.min(scored_from, part.samples // 4)
      local e = (part:column(all.outputs[o]) - y:column(o)):slice(skip + 1, part.samples)
      square, count = square + pl.sum(e * e), count + #e
    end
    errors[o] = math.sqrt(square / count)
    mean = mean + (errors[o] / deviations[o]) ^ 2 / #all.outputs
  end
  return errors, mean == mean and mean or math.huge
end

-- Outputs that drive each other, as the joints of an arm do, need a model of all of them.
local function identify_jointly(single)
  local parts, inputs, deviations = {}, #all.inputs, {}
  for i = 1, all.experiments do parts[i] = all:experiment(i) end
  for o, label in ipairs(all.outputs) do deviations[o] = pl.std(all:column(label)) end
  local most = math.floor(8000 * math.max(0.5, math.min(effort, 4)))
  local searched = parts
  if all.samples > 1.5 * most then
    local keep = most / all.samples / 4
    searched = cut(parts, {{0.05, 0.05 + keep}, {0.35, 0.35 + keep}, {0.65, 0.65 + keep}, {1 - keep, 1}})
  end
  local split = splits_of(searched, 1e9)[1]
  local rows = split.train.samples
  print(("\nAll outputs together: neural state-space models, and networks beside a linear model, identified on %d samples"):format(rows))
  print(("  %-44s %s"):format("structure; RMSE of the free run, held back", table.concat(all.outputs, "  ")))

  -- Each input acts as late as on the output on which it acts first.
  local ny, nu, from = 1, 1, {}
  for i = 1, inputs do from[i] = math.huge end
  for _, s in ipairs(single) do
    ny, nu = math.max(ny, math.min(s.ny, 3)), math.max(nu, math.min(s.nu, 3))
    for i = 1, inputs do from[i] = math.min(from[i], s.delay + s.later[i]) end
  end
  local function channel(label, letter, i) return label:match("^[%a_][%w_]*$") or letter .. i end
  local function lags(of_y, of_u)
    local list = {}
    for o, label in ipairs(all.outputs) do list[#list + 1] = ("%s(k-1..%d)"):format(channel(label, "y", o), of_y) end
    for i, label in ipairs(all.inputs) do
      list[#list + 1] = from[i] < 0 and ("%s(k..%d)"):format(channel(label, "u", i), of_u - 1) or
                        ("%s(k-%d..%d)"):format(channel(label, "u", i), from[i] + 1, from[i] + of_u)
    end
    return table.concat(list, ", ")
  end
  local budget, spent, best, tried = 200 * effort, 0, nil, {}
  local function try(of_y, of_u, neurons, decay)
    local signals = #all.outputs * of_y + inputs * of_u
    local parameters = neurons * (signals + 1) + #all.outputs * (neurons + 1 + signals)
    local work = rows * #all.outputs * parameters ^ 2 * 120e-9
    local key = table.concat({of_y, of_u, neurons, ("%.1g"):format(decay)}, " ")
    if tried[key] or spent + work > budget then return end
    tried[key] = true
    spent = spent + work
    local ok, model = pcall(identify.mlp, split.train,
                            {regressors = lags(of_y, of_u), hidden = neurons, direct = true, simulation = true, starts = 6, refined = 2,
                             one_step_iterations = 60, iterations = 60, horizons = {20 + 4 * (of_y + of_u), 0}, decay = decay, seed = seed})
    if not ok then return end
    local errors, mean = judge_jointly(model, split.held_parts, deviations)
    if not errors then return end
    local texts = {}
    for o, e in ipairs(errors) do texts[o] = ("%.5g"):format(e) end
    print(("  %-44s %s"):format(("%d neurons, %d of each y, %d of each u, decay %.1g"):format(neurons, of_y, of_u, decay), table.concat(texts, "  ")))
    if not best or mean < best.mean then
      best = {model = model, mean = mean, errors = errors, of_y = of_y, of_u = of_u, neurons = neurons, decay = decay}
    end
  end
  -- A state that all outputs share. What it was made of goes on where it is best.
  local function try_state(order, neurons, decay)
    local outputs = #all.outputs
    local parameters = neurons * (order + inputs + 1) + order * (neurons + order + inputs + 1) + outputs * (order + inputs + 1)
    local work = rows * (outputs * parameters ^ 2 * 3e-10 + 1e-6) * (15 * 4 + 60)
    local key = table.concat({"state", order, neurons, ("%.1g"):format(decay)}, " ")
    if order < 1 or order > 12 or neurons > 40 or tried[key] or spent + work > budget then return end
    tried[key] = true
    spent = spent + work
    local late, direct = {}, false
    for i = 1, inputs do late[i], direct = math.max(0, from[i]), direct or from[i] < 0 end
    local ok, model = pcall(identify.neural_state_space, split.train, {order = order, hidden = neurons, delay = late, feedthrough = direct,
                            decay = decay, starts = 4, refined = 1, iterations = 60, seed = seed})
    if not ok then return end
    local errors, mean = judge_jointly(model, split.held_parts, deviations)
    if not errors then return end
    local texts = {}
    for o, e in ipairs(errors) do texts[o] = ("%.5g"):format(e) end
    print(("  %-44s %s"):format(("state of order %d, %d neurons, decay %.1g"):format(order, neurons, decay), table.concat(texts, "  ")))
    if not best or mean < best.mean then best = {model = model, mean = mean, errors = errors, order = order, neurons = neurons, decay = decay} end
  end
  for _, order in ipairs{#all.outputs, #all.outputs + 1, 2 * #all.outputs} do try_state(order, 8, 1e-2) end
  for _ = 1, 4 do
    local b = best
    if not b then break end
    try_state(b.order + 1, b.neurons, b.decay)
    try_state(b.order, math.ceil(1.6 * b.neurons), b.decay)
    try_state(b.order, b.neurons, b.decay / 10)
    try_state(b.order, b.neurons, b.decay * 10)
    if best == b then break end
  end
  budget = budget + spent
  for _, neurons in ipairs{4, 8, 14} do
    try(math.min(ny, 2), math.min(nu, 2), neurons, 1e-2)
  end
  if not best then
    print "  none runs freely within this effort"
    return
  end
  for _ = 1, 3 do
    local b = best
    if b.order then break end
    for _, factor in ipairs{0.1, 10} do try(b.of_y, b.of_u, b.neurons, b.decay * factor) end
    try(b.of_y + 1, b.of_u, b.neurons, b.decay)
    try(b.of_y, b.of_u + 1, b.neurons, b.decay)
    if b.of_y > 1 then try(b.of_y - 1, b.of_u, b.neurons, b.decay) end
    try(b.of_y, b.of_u, math.floor(1.6 * b.neurons), b.decay)
    if best == b then break end
  end
  local final = best.model
  local ok, refined = pcall(function() return final:fit_free_run(all, {iterations = 60, decay = best.decay}) end)
  if ok then
    local _, before = judge_jointly(final, parts, deviations)
    local _, after = judge_jointly(refined, parts, deviations)
    if after < before then final = refined end
  end
  local stem = ("out/%s-together"):format(name)
  final:save(stem .. ".yaml")
  local test_errors
  if test then
    local tests = {}
    for i = 1, test.experiments do tests[i] = test:experiment(i) end
    test_errors = judge_jointly(final, tests, deviations)
    for i, part in ipairs(test_errors and tests or {}) do
      local run, columns, labels = free_run(final, part), {}, {}
      for k = 1, part.samples do
        columns[k] = {}
        for o, label in ipairs(all.outputs) do
          columns[k][o], columns[k][#all.outputs + o] = part:column(label)[k], run(k, o)
          labels[o], labels[#all.outputs + o] = label, "free_run_" .. o
        end
      end
      identify.data{u = part.u, y = pl.matrix(columns), Ts = part.Ts, inputs = all.inputs, outputs = labels}
              :save(("%s-test%s.csv"):format(stem, #tests > 1 and i or ""))
    end
  end
  print(("  %-24s %14s %14s%s"):format("RMSE of the free run", "held: alone", "together", test and "    test: alone       together" or ""))
  for o, label in ipairs(all.outputs) do
    print(("  %-24s %14.5g %14.5g%s   %s"):format(label, single[o].held, best.errors[o], test and (" %14.5g %14.5g"):format(
      single[o].test or math.huge, test_errors and test_errors[o] or math.huge) or "",
      best.errors[o] < single[o].held and "the model of all outputs is better" or "its own model is better"))
  end
  print(("  written: %s.yaml%s"):format(stem, test_errors and ", " .. stem .. "-test.csv" or ""))
end

local single = {}
local varying = 0
for output = 1, #all.outputs do
  single[output] = identify_output(output)
  if single[output] then varying = varying + 1 end
end
if varying == 0 then error("none of the outputs varies", 0) end
if varying > 1 and varying == #all.outputs then identify_jointly(single) end
