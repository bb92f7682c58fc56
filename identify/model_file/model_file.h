// Model files: YAML, `plantloop_model: 1` first, then the type and what that type needs.
//
//   plantloop_model: 1
//   type: linear_model
//   data: {hash: ..., samples: ..., ...}    where the numbers come from
//   ...
//
// Numbers are written with the fewest digits that read back as the same bits.

#pragma once

#include <string>
#include <string_view>

#include "identify/data/data_set.h"
#include "identify/model_file/item.h"

namespace plantloop::identify {

inline constexpr int model_file_version = 1;

// The file of a model: `content` is a mapping without the keys `plantloop_model` and `type`.
std::string to_yaml(std::string_view type, const Item& content);

// The file's mapping with `type` and all other keys, each with its place. `name` is the file's in messages. Raises
// IdentifyError: no YAML, no model file, a version that this program does not know.
Item read_model_file(std::string_view text, const std::string& name);

// What a model says about the data it was made of: hash, samples, missing values, experiments, sampling time, signals
// with units.
Item data_item(const DataSet& data);
// Of a model made by hand: sampling time and signals alone.
Item channels_item(double Ts, const std::vector<Channel>& inputs, const std::vector<Channel>& outputs);
// The signals of such an item, and the sampling time: a data set without experiments.
DataSet channels_of(const Item& data);

}  // namespace plantloop::identify
