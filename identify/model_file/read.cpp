// Reading model files: YAML by the reader of diagrams, then items with their places.

#include <algorithm>
#include <memory>

#include "engine/diagram/document.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"

namespace plantloop::identify {

// Builds items from the document's tree.
class ItemReader {
 public:
  static Item read(const Node& node) {
    Item item;
    item.place_ = to_string(node.mark);
    if (node.is_mapping()) {
      item.keys_ = node.keys;
    } else if (node.is_sequence()) {
      item.kind_ = Item::Kind::list;
    } else {
      item.kind_ = Item::Kind::scalar;
      item.text_ = node.text;
      item.is_text_ = node.quoted;
    }
    item.values_.reserve(node.items.size());
    for (const Node& child : node.items) item.values_.push_back(read(child));
    return item;
  }
};

namespace {

std::vector<Channel> channels(const Item& data, std::string_view key) {
  std::vector<Channel> list;
  for (const Item& item : data.items(key)) {
    item.only({"name", "unit"});
    list.push_back({item.text("name"), item.has("unit") ? item.text("unit") : ""});
  }
  return list;
}

// No line but blank ones and comments.
bool holds_nothing(std::string_view text) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    const std::size_t first = line.find_first_not_of(" \t\r");
    if (first != std::string_view::npos && line[first] != '#') return false;
    text.remove_prefix(std::min(text.size(), line.size() + 1));
  }
  return true;
}

}  // namespace

Item read_model_file(std::string_view text, const std::string& name) {
  if (holds_nothing(text))
    fail("{} is empty; a model file begins with 'plantloop_model: {}'", name, model_file_version);
  const auto source = std::make_shared<const Source>(Source{name, std::string(text)});
  Report report;
  const Node root = read_document(source, report);
  if (report.has_errors()) throw IdentifyError(to_text(report));
  if (!root.is_mapping() || root.find("plantloop_model") == nullptr) {
    fail("{} is no model file: it does not begin with 'plantloop_model: {}'", name, model_file_version);
  }
  Item item = ItemReader::read(root);
  const long long version = item.integer("plantloop_model");
  if (version != model_file_version) {
    item.at("plantloop_model")
        .wrong(fmt::format("this program reads version {} of model files, this is version {}", model_file_version,
                           version));
  }
  if (item.text("type").empty()) item.at("type").wrong("the type of the model is missing");
  return item;
}

DataSet channels_of(const Item& data) {
  DataSet result;
  result.Ts = data.number("Ts");
  result.inputs = channels(data, "inputs");
  result.outputs = channels(data, "outputs");
  return result;
}

}  // namespace plantloop::identify
