-- What cannot be measured.
local metrics = pl.identify.metrics
says(metrics, {}, {})
says(metrics, {pl.nan}, {1})
says(metrics, {1, 2}, {1})
says(metrics, {1, 2}, {1, 2}, {skip = 5})
says(metrics, {1, 2}, {1, 2}, {skip = -1})
says(metrics, {1, 2}, {1, 2}, {variance = {0, 1}})
says(metrics, {1, 2}, {1, 2}, {variance = {1, -1}, skip = 1})
says(metrics, {1, 2}, {1, 2}, {variance = {1}})
says(metrics, {1, 2, 3}, {1, pl.nan, pl.nan})
says(metrics, {1, 2, 3, 4}, {1, 2, 3, pl.nan}, {skip = 2})
says(metrics, {1, 2, 3}, {pl.nan, pl.nan, pl.nan})
-- What can: samples before the first prediction, samples that were not measured, and gaps on request.
local m = metrics({5, 1, pl.nan, 3}, {pl.nan, 1, pl.nan, 4})
print(m.samples, m.without_prediction, m.SE)
m = metrics({1, 2, 3}, {1, pl.nan, 5}, {partial = true})
print(m.samples, m.without_prediction, m.SE)
