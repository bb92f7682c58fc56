// Values of identification to scripts and back.

#include "scripts/host/identify_objects.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

#include "engine/base/files.h"

namespace plantloop::lua {

void push_numbers(lua_State* L, const Eigen::VectorXd& x) {
  push_vector(L, {x.data(), static_cast<std::size_t>(x.size())});
}

void push_matrix(lua_State* L, const Eigen::MatrixXd& m) {
  Array& a = push_array(L, m.rows(), m.cols(), true);
  std::copy(m.data(), m.data() + m.size(), a.data());
}

void push_outputs(lua_State* L, const std::vector<Eigen::MatrixXd>& parts) {
  Eigen::Index rows = 0;
  for (const Eigen::MatrixXd& p : parts) rows += p.rows();
  Eigen::MatrixXd all(rows, parts.empty() ? 0 : parts[0].cols());
  rows = 0;
  for (const Eigen::MatrixXd& p : parts) {
    all.middleRows(rows, p.rows()) = p;
    rows += p.rows();
  }
  push_columns(L, all);
}

void push_residuals(lua_State* L, const identify::DataSet& data, std::vector<Eigen::MatrixXd> predictions) {
  for (std::size_t i = 0; i < predictions.size(); ++i) predictions[i] = data.experiments[i].y - predictions[i];
  push_outputs(L, predictions);
}

bool starts_at_zero(lua_State* L, int index) {
  const Options o(L, index, "the options of simulate", {"start"});
  const std::string start = o.text("start", "measured");
  if (start != "measured" && start != "zero") o.wrong("start", "measured or zero");
  return start == "zero";
}

identify::StateStart start_of(const Options& o) {
  const std::string start = o.text("start", "estimated");
  if (start != "estimated" && start != "zero") o.wrong("start", "estimated or zero");
  return start == "zero" ? identify::StateStart::zero : identify::StateStart::estimated;
}

void push_columns(lua_State* L, const Eigen::MatrixXd& m) {
  if (m.cols() == 1) {
    push_numbers(L, m.col(0));
  } else {
    push_matrix(L, m);
  }
}

void push_texts(lua_State* L, const std::vector<std::string>& list) {
  lua_createtable(L, static_cast<int>(list.size()), 0);
  lua_Integer at = 0;
  for (const std::string& text : list) {
    push_text(L, text);
    lua_rawseti(L, -2, ++at);
  }
}

void push_report(lua_State* L, const identify::FitReport& report) {
  lua_newtable(L);
  const auto number = [L](const char* key, double value) {
    lua_pushnumber(L, value);
    lua_setfield(L, -2, key);
  };
  const auto text = [L](const char* key, const std::string& value) {
    push_text(L, value);
    lua_setfield(L, -2, key);
  };
  text("method", report.method);
  number("samples", static_cast<double>(report.samples));
  number("parameters", static_cast<double>(report.parameters));
  number("reached", report.reached);
  text("measure", report.measure);
  number("iterations", static_cast<double>(report.iterations));
  text("stopped", report.stopped);
  push_texts(L, report.tried);
  lua_setfield(L, -2, "tried");
  push_texts(L, report.warnings);
  lua_setfield(L, -2, "warnings");
  text("text", identify::to_text(report));
}

Eigen::VectorXd vector_of(lua_State* L, int index, std::string_view what) {
  const Array& a = vector_argument(L, index, what);
  return Eigen::Map<const Eigen::VectorXd>(a.data(), a.size());
}

Eigen::MatrixXd matrix_of(lua_State* L, int index, std::string_view what) {
  return matrix_view(std::as_const(array_argument(L, index, what)));
}

std::vector<int> integers(lua_State* L, const Options& options, const char* key) {
  std::vector<int> list;
  if (!options.push(key)) return list;
  const Eigen::VectorXd values = vector_of(L, -1, key);
  lua_pop(L, 1);
  for (const double v : values) {
    if (v != std::floor(v) || std::fabs(v) > 1e6) {
      throw ScriptError(fmt::format("'{}' must be whole numbers, here is {}", key, v));
    }
    list.push_back(static_cast<int>(v));
  }
  return list;
}

int integer(const Options& options, const char* key, int fallback) {
  const std::optional<double> value = options.number(key);
  if (!value) return fallback;
  if (*value != std::floor(*value) || std::fabs(*value) > 1e9) options.wrong(key, "a whole number");
  return static_cast<int>(*value);
}

std::vector<std::string> texts(lua_State* L, const Options& options, const char* key) {
  std::vector<std::string> list;
  if (!options.push(key)) return list;
  if (lua_type(L, -1) == LUA_TSTRING) {
    list.emplace_back(lua_tostring(L, -1));
  } else {
    if (!lua_istable(L, -1)) options.wrong(key, "a text or a list of texts");
    for (lua_Integer i = 1; lua_rawgeti(L, -1, i) != LUA_TNIL; ++i) {
      list.push_back(text_argument(L, -1, key));
      lua_pop(L, 1);
    }
    lua_pop(L, 1);
  }
  lua_pop(L, 1);
  return list;
}

identify::FitControl control_of(lua_State* L) {
  const Session& of = session_of(L);
  std::optional<std::chrono::steady_clock::time_point> deadline;
  if (const double left = of.sandbox.seconds_left(); std::isfinite(left)) {
    deadline = std::chrono::steady_clock::now() +
               std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(left));
  }
  return {[L](double fraction) {
            Session& session = session_of(L);
            session.sandbox.work(L, 1e5);
            if (session.options.progress) session.options.progress("", std::clamp(fraction, 0.0, 0.999));
          },
          of.options.cancel, deadline};
}

void push_data(lua_State* L, identify::DataSet data) {
  const auto channels = static_cast<std::size_t>(data.inputs.size() + data.outputs.size());
  const std::size_t bytes = static_cast<std::size_t>(data.samples()) * channels * sizeof(double);
  push_held(L, data_kind, std::move(data), bytes);
}

const identify::DataSet& data_argument(lua_State* L, int index) {
  return held_argument<identify::DataSet>(L, index, data_kind, "data");
}

void write_and_push(lua_State* L, const std::string& path, std::string_view text,
                    std::initializer_list<const char*> endings) {
  const std::string ending = std::filesystem::path(path).extension().string();
  if (std::find(endings.begin(), endings.end(), ending) == endings.end()) {
    throw ScriptError(fmt::format("cannot write '{}': the name must end in {}", path, fmt::join(endings, " or ")));
  }
  const FileResult place = session_of(L).writable(path);
  const std::string error = place.ok() ? write_file(place.value, text) : place.error;
  if (!error.empty()) throw ScriptError(fmt::format("cannot write '{}': {}", path, error));
  push_text(L, place.value);
}

std::string read_text(lua_State* L, const std::string& path) {
  const Session& session = session_of(L);
  const FileResult place = session.readable(path);
  FileResult file = place.ok() ? read_file(place.value, session.sandbox.bytes_left() / 4) : place;
  if (!file.ok()) throw ScriptError(fmt::format("cannot read '{}': {}", path, file.error));
  return std::move(file.value);
}

}  // namespace plantloop::lua
