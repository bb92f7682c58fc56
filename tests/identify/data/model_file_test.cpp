// Model files: the same bits back, and complaints that say where.

#include "identify/model_file/model_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "identify/error.h"
#include "identify/fit_report.h"
#include "identify/random.h"

namespace plantloop::identify {
namespace {

std::string message(const std::string& text, const std::function<void(const Item&)>& use = {}) {
  try {
    const Item item = read_model_file(text, "pump.yaml");
    if (use) use(item);
  } catch (const IdentifyError& e) {
    return e.what();
  }
  return "no error";
}

TEST(ModelFile, NumbersComeBackWithTheSameBits) {
  Random random(7);
  Eigen::MatrixXd m(40, 9);
  for (double& v : m.reshaped()) v = std::ldexp(random.normal(), static_cast<int>(random.index(600)) - 300);
  m(0, 0) = -0.0;
  m(1, 0) = std::numeric_limits<double>::denorm_min();
  m(2, 0) = std::numeric_limits<double>::infinity();
  m(3, 0) = std::numeric_limits<double>::max();
  const Eigen::VectorXd v = m.reshaped();
  const std::string text = to_yaml("test", Item().set("m", m).set("v", v).set("x", 0.1 + 0.2));
  const Item back = read_model_file(text, "pump.yaml");
  const Eigen::MatrixXd again = back.matrix("m", 40, 9);
  EXPECT_EQ(std::memcmp(again.data(), m.data(), sizeof(double) * 360), 0);
  const Eigen::VectorXd list = back.vector("v", 360);
  EXPECT_EQ(std::memcmp(list.data(), v.data(), sizeof(double) * 360), 0);
  EXPECT_EQ(back.number("x"), 0.1 + 0.2);
}

TEST(ModelFile, TextsListsAndMappingsComeBack) {
  FitReport report;
  report.method = "least squares";
  report.tried = {"na 2, nb 1: \"good\"", "a: b # no comment", "", "true", "two\nlines"};
  report.warnings = {};
  report.reached = std::numeric_limits<double>::quiet_NaN();
  Item parts = Item::list();
  parts.add(Item().set("name", "a b").set("size", 3)).add(Item().set("name", "y").set("size", -4));
  const std::string text =
      to_yaml("test", Item().set("fit", to_item(report)).set("parts", parts).set("on", true).set("none", Item::list()));
  const Item back = read_model_file(text, "pump.yaml");
  EXPECT_EQ(back.text("type"), "test");
  EXPECT_EQ(fit_report_of(back.at("fit")).tried, report.tried);
  EXPECT_TRUE(std::isnan(fit_report_of(back.at("fit")).reached));
  EXPECT_EQ(back.items("parts")[1].text("name"), "y");
  EXPECT_EQ(back.items("parts")[1].integer("size"), -4);
  EXPECT_TRUE(back.flag("on"));
  EXPECT_EQ(back.vector("none").size(), 0);
}

TEST(ModelFile, IsReadableText) {
  const std::string text = to_yaml("arx", Item()
                                              .set("data", Item().set("Ts", 0.02).set("unit", "rad/s"))
                                              .set("A", Eigen::VectorXd(Eigen::Vector3d(1, -1.5, 0.7)))
                                              .set("P", Eigen::MatrixXd(Eigen::Matrix2d::Identity())));
  EXPECT_EQ(text,
            "plantloop_model: 1\ntype: arx\ndata:\n  Ts: 0.02\n  unit: \"rad/s\"\nA: [1, -1.5, 0.7]\nP:\n"
            "  - [1, 0]\n  - [0, 1]\n");
}

TEST(ModelFile, SaysWhereAFileIsWrong) {
  EXPECT_EQ(message("a: 1\n"), "pump.yaml is no model file: it does not begin with 'plantloop_model: 1'");
  EXPECT_EQ(message("plantloop_model: 2\ntype: arx\n"),
            "pump.yaml:1:18: this program reads version 1 of model files, this is version 2");
  const std::string head = "plantloop_model: 1\ntype: arx\n";
  EXPECT_EQ(message(head + "Ts: fast\n", [](const Item& i) { i.number("Ts"); }),
            "pump.yaml:3:5: 'Ts' must be a number, it is 'fast'");
  EXPECT_EQ(message(head, [](const Item& i) { i.number("Ts"); }),
            "pump.yaml:1:1: the key 'Ts' is missing; there are: plantloop_model, type");
  EXPECT_EQ(message(head + "A: [1, 2]\n", [](const Item& i) { i.vector("A", 3); }),
            "pump.yaml:3:4: 'A' must be 3 numbers, it has 2");
  EXPECT_EQ(message(head + "W: [[1, 2], [3]]\n", [](const Item& i) { i.matrix("W", 2, 2); }),
            "pump.yaml:3:13: a row of 'W' must be a list of 2 numbers");
  EXPECT_EQ(message(head + "ouputs: 1\n",
                    [](const Item& i) {
                      i.only({"plantloop_model", "type", "outputs"});
                    }),
            "pump.yaml:3:9: there is no key 'ouputs' here, did you mean 'outputs'; there are: plantloop_model, type, "
            "outputs");
}

TEST(ModelFile, RemembersTheDataItWasMadeOf) {
  const DataSet data = make_data_set(Eigen::VectorXd::Ones(5), Eigen::VectorXd::Ones(5), 0.1, {{"flow", "l/s"}});
  const Item back = read_model_file(to_yaml("arx", Item().set("data", data_item(data))), "pump.yaml");
  EXPECT_EQ(back.at("data").text("hash"), hash(data));
  const DataSet channels = channels_of(back.at("data"));
  EXPECT_EQ(channels.inputs, data.inputs);
  EXPECT_EQ(channels.outputs, data.outputs);
  EXPECT_EQ(channels.Ts, 0.1);
}

}  // namespace
}  // namespace plantloop::identify
