// Writing model files: block style, short lists of numbers on one line, long ones wrapped.

#include <algorithm>
#include <array>
#include <cassert>

#include "engine/base/text.h"
#include "identify/error.h"
#include "identify/model_file/model_file.h"

namespace plantloop::identify {
namespace {

constexpr std::size_t widest = 110;

// A word that is nothing else in YAML stands without quotes.
bool is_plain(const std::string& text) {
  constexpr std::array reserved{"true", "false", "null", "yes", "no",   "on",   "off",
                                "y",    "n",     "nan",  "inf", "True", "False"};
  return is_identifier(text) && std::find(reserved.begin(), reserved.end(), text) == reserved.end();
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '\n') {
      result += "\\n";
    } else if (c == '\t') {
      result += "\\t";
    } else {
      if (c == '"' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result + '"';
}

std::string scalar_text(const Item& item) {
  return item.is_text() && !is_plain(item.scalar()) ? quoted(item.scalar()) : item.scalar();
}

bool is_flat(const Item& item) {
  return std::all_of(item.values().begin(), item.values().end(),
                     [](const Item& i) { return i.kind() == Item::Kind::scalar; });
}

class Writer {
 public:
  std::string text;

  void mapping(const Item& item, std::size_t indent) {
    for (std::size_t i = 0; i < item.keys().size(); ++i) {
      if (i > 0 || !after_dash_) pad(indent);
      after_dash_ = false;
      text += item.keys()[i] + ':';
      value(item.values()[i], indent);
    }
  }

 private:
  void pad(std::size_t indent) { text.append(indent, ' '); }

  // What stands behind "key:".
  void value(const Item& item, std::size_t indent) {
    if (item.kind() == Item::Kind::scalar) {
      text += ' ' + scalar_text(item) + '\n';
    } else if (item.values().empty()) {
      text += item.kind() == Item::Kind::list ? " []\n" : " {}\n";
    } else if (item.kind() == Item::Kind::mapping) {
      text += '\n';
      mapping(item, indent + 2);
    } else if (is_flat(item)) {
      text += ' ';
      flow(item, indent + 2);
    } else {
      text += '\n';
      entries(item, indent + 2);
    }
  }

  void entries(const Item& list, std::size_t indent) {
    for (const Item& item : list.values()) {
      pad(indent);
      text += "- ";
      if (item.kind() == Item::Kind::scalar) {
        text += scalar_text(item) + '\n';
      } else if (item.values().empty()) {
        text += item.kind() == Item::Kind::list ? "[]\n" : "{}\n";
      } else if (item.kind() == Item::Kind::mapping) {
        after_dash_ = true;
        mapping(item, indent + 2);
      } else {
        assert(is_flat(item));
        flow(item, indent + 2);
      }
    }
  }

  // [1, 2, 3] with lines that continue at the indent.
  void flow(const Item& list, std::size_t indent) {
    std::size_t column = text.size() - (text.rfind('\n') + 1);
    text += '[';
    bool first = true;
    for (const Item& item : list.values()) {
      const std::string next = scalar_text(item);
      if (!first) {
        text += ',';
        if (column + next.size() + 2 > widest) {
          text += '\n';
          pad(indent);
          column = indent;
        } else {
          text += ' ';
        }
      }
      first = false;
      text += next;
      column += next.size() + 2;
    }
    text += "]\n";
  }

  bool after_dash_ = false;
};

Item channel_items(const std::vector<Channel>& channels) {
  Item list = Item::list();
  for (const Channel& c : channels) {
    Item item;
    item.set("name", c.name);
    if (!c.unit.empty()) item.set("unit", c.unit);
    list.add(std::move(item));
  }
  return list;
}

}  // namespace

std::string to_yaml(std::string_view type, const Item& content) {
  Writer writer;
  writer.text = fmt::format("plantloop_model: {}\ntype: {}\n", model_file_version, type);
  writer.mapping(content, 0);
  return writer.text;
}

Item channels_item(double Ts, const std::vector<Channel>& inputs, const std::vector<Channel>& outputs) {
  return Item().set("Ts", Ts).set("inputs", channel_items(inputs)).set("outputs", channel_items(outputs));
}

Item data_item(const DataSet& data) {
  Item item;
  item.set("hash", hash(data))
      .set("samples", data.samples())
      .set("experiments", data.experiments.size())
      .set("missing", data.missing())
      .set("Ts", data.Ts)
      .set("inputs", channel_items(data.inputs))
      .set("outputs", channel_items(data.outputs));
  return item;
}

}  // namespace plantloop::identify
