// Units: texts to dimensions and factors.

#include "engine/base/units.h"

#include <gtest/gtest.h>

#include <numbers>

namespace plantloop {
namespace {

Unit unit(const char* text) {
  const auto result = parse_unit(text);
  const auto* error = std::get_if<UnitError>(&result);
  EXPECT_EQ(error, nullptr) << text << ": " << (error ? error->message : "");
  return error ? Unit{} : std::get<Unit>(result);
}

UnitError error(const char* text) {
  const auto result = parse_unit(text);
  EXPECT_TRUE(std::holds_alternative<UnitError>(result)) << text;
  return std::holds_alternative<UnitError>(result) ? std::get<UnitError>(result) : UnitError{};
}

TEST(Units, ProductsQuotientsAndPowers) {
  EXPECT_EQ(dimension_text(unit("kg m^2")), "m^2 kg");
  EXPECT_EQ(dimension_text(unit("N m/A")), "m^2 kg s^-2 A^-1");
  EXPECT_EQ(dimension_text(unit("J/kg/K")), "m^2 s^-2 K^-1");
  EXPECT_EQ(dimension_text(unit("m s^-2")), dimension_text(unit("m/s^2")));
  EXPECT_EQ(dimension_text(unit("1/min")), "s^-1");
  EXPECT_EQ(dimension_text(unit("")), "1");
}

TEST(Units, ASlashDividesByOneFactor) { EXPECT_TRUE(unit("N m/A s").same_dimension(unit("N m s/A"))); }

TEST(Units, RadIsOne) { EXPECT_EQ(unit("V s/rad"), unit("V s")); }

TEST(Units, FactorsToSi) {
  EXPECT_DOUBLE_EQ(unit("km/h").factor, 1 / 3.6);
  EXPECT_DOUBLE_EQ(unit("ms").factor, 1e-3);
  EXPECT_DOUBLE_EQ(unit("mbar").factor, 100);
  EXPECT_DOUBLE_EQ(unit("l/min").factor, 1e-3 / 60);
  EXPECT_DOUBLE_EQ(unit("rpm").factor, std::numbers::pi / 30);
  EXPECT_DOUBLE_EQ(unit("cm^3").factor, 1e-6);
  EXPECT_DOUBLE_EQ(unit("%").factor, 0.01);
  EXPECT_DOUBLE_EQ(unit("degC").offset, 273.15);
  EXPECT_DOUBLE_EQ(unit("µm").factor, unit("um").factor);
}

TEST(Units, ElectricalUnitsFitTogether) {
  EXPECT_TRUE(unit("V").same_dimension(unit("Ohm A")));
  EXPECT_TRUE(unit("H").same_dimension(unit("V s/A")));
  EXPECT_TRUE(unit("F").same_dimension(unit("C/V")));
  EXPECT_TRUE(unit("T").same_dimension(unit("Wb/m^2")));
  EXPECT_TRUE(unit("W").same_dimension(unit("V A")));
  EXPECT_TRUE(unit("S").same_dimension(unit("A/V")));
  EXPECT_TRUE(unit("Pa").same_dimension(unit("N/m^2")));
}

TEST(Units, MinutesAreNoMilliInches) { EXPECT_DOUBLE_EQ(unit("min").factor, 60); }

TEST(Units, MistakesHaveAPlaceAndAHint) {
  EXPECT_EQ(error("kg furlong").at, 3U);
  EXPECT_EQ(error("kg furlong").length, 7U);
  EXPECT_EQ(error("Kg").hint, "did you mean 'kg'?");
  EXPECT_EQ(error("m²").hint, "a power is written with ^: m^2");
  EXPECT_EQ(error("N·m").hint, "a product of units is written with a space: N m");
  EXPECT_EQ(error("second").hint, "write s");
  for (const char* text : {"/", "m/", "m//s", "m^", "m^1.5", "(m)", "degC/s", "m^99", "^2", "m 2"}) error(text);
}

}  // namespace
}  // namespace plantloop
