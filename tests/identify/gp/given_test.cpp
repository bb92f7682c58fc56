// Processes at given hyperparameters: likelihood, gradient, predictions and leave-one-out of every covariance against
// numbers of 50 digits, by inverses, determinants and derivatives of a multiple-precision library.

#include <gtest/gtest.h>

#include <cmath>

#include "identify/error.h"
#include "identify/gp/gp_map.h"
#include "tests/identify/gp/fixture.h"

namespace plantloop::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd seven_x() {
  MatrixXd x(7, 2);
  x << 0.10, -0.70, -0.45, 0.30, 0.80, 0.55, -1.20, -0.15, 0.33, 1.10, -0.66, -0.98, 1.50, -0.24;
  return x;
}
VectorXd seven_y() {
  VectorXd y(7);
  y << 0.42, -0.17, 0.93, -0.58, 0.77, -1.05, 1.20;
  return y;
}
constexpr double noise = 0.05;

struct Case {
  std::string covariance;
  MeanFunction mean;
  std::vector<double> theta;
  double log_likelihood;
  std::vector<double> gradient;      // by log theta and log v0
  std::vector<double> predicted;     // mean and variance at two points
  std::vector<double> mean_of_each;  // leave-one-out
  std::vector<double> variance_of_each;
  double log_probability;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> list{
      {"se_ard",
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -7.914783712191699,
       {-0.06020885542938522, -0.8432989663360791, -1.377905423634367, -0.08043977155520135},
       {0.6795517974929978, 0.1090872393249821, 0.1247737271664334, 0.7837887118911153},
       {-0.4424545759561222, 0.3448186461210413, 0.823436935086051, -0.8412632780612966, 0.315378535456696,
        0.006356144245826413, 0.8816953240233644},
       {0.4833635318597354, 0.476835744507587, 0.4731185803645995, 0.5605856166875421, 0.6284723638563426,
        0.5070943698336319, 0.8180846388764358},
       -6.80989483706424},
      {"matern_3_2",
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -8.291316642139638,
       {-0.08556195989723562, -0.6437469621799644, -1.692796583039226, -0.1149350483835391},
       {0.5939562116143431, 0.3275405110533581, 0.1418154158682439, 1.023064218274977},
       {-0.3407609637102854, 0.1934554721541394, 0.6963545465432547, -0.4663486154018108, 0.3572797835691657,
        0.02355165962449212, 0.4969393033799022},
       {0.7747084230616866, 0.7985110952128716, 0.7677563472900164, 0.8685670648825335, 0.890285049100418,
        0.8075469906881276, 1.077513846760826},
       -7.400037768748585},
      {"matern_5_2",
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -8.167893821987816,
       {-0.1162186169962498, -0.7412834841876791, -1.623877029941548, -0.1164680153784749},
       {0.6524030625245078, 0.2314671765491462, 0.1431254499519444, 0.9674871324012182},
       {-0.3780423411684684, 0.2270207613860031, 0.7501836287601962, -0.5697235715855213, 0.3584853057096918,
        0.01775229032963443, 0.591972541322583},
       {0.6843770425927165, 0.7058439422306093, 0.6753144270854549, 0.7803258006353613, 0.8101837165694694,
        0.7138845487335482, 1.017504561553959},
       -7.169019538922791},
      {"rational_quadratic",
       MeanFunction::zero,
       {0.8, 1.7, 1.3, 0.6},
       -7.84400167875461,
       {0.2051091797572513, -0.7594415048650811, -0.9863498609858008, 0.03027214557775569, -0.1040573972809443},
       {0.6108963563730923, 0.1536287142111354, 0.1812681929922694, 0.6824449990098539},
       {-0.3448226331568441, 0.2248358005685414, 0.7824768122775237, -0.5713864963466095, 0.4324651866438526,
        0.04636217577666933, 0.6748631030792439},
       {0.446255335338516, 0.4583749973048769, 0.4397943207178551, 0.5333373476611953, 0.5772333426431179,
        0.496639972820307, 0.7298541161337278},
       -6.479939918438794},
      {"linear",
       MeanFunction::zero,
       {0.9, 0.4, 0.7},
       -6.336072500318589,
       {-0.1769232779557643, -0.3475816040271819, -0.47289511323086, 1.732636609736356},
       {0.2346093604581662, 0.01037624975079255, -0.08239826651484321, 0.05406678244016012},
       {-0.1455265348722839, -0.03250482892282793, 0.9712841268291646, -0.9481990868848058, 0.7956393082391526,
        -0.292994461390977, 1.286020224903488},
       {0.07137659570904475, 0.06678496912813924, 0.0718953287500262, 0.09207747694077001, 0.1056131727448804,
        0.09263185888514853, 0.1380412959546775},
       -4.200105287727692},
      {"periodic",
       MeanFunction::zero,
       {0.6, 0.3, 1.9, 2.7, 1.1},
       -12.3931851914117,
       {2.252654020758656, 3.121253414951878, -21.44450825622757, -5.053946264326289, 2.303112023966253,
        1.123942760180652},
       {0.1494854774379953, 0.2093374642545285, -0.4539463357951355, 0.3236634559036063},
       {0.5676405009837777, 1.210610621836081, -0.6175682017188183, 0.8905805983495751, 0.2557418188576274,
        0.7379901985145548, -0.5149996832421877},
       {0.6593243841231781, 0.4116759143782709, 0.5042382811521338, 0.5622016866704388, 0.696768121054326,
        0.7554924752859572, 0.3456890383261375},
       -17.48772714742325},
      {"neural_network",
       MeanFunction::zero,
       {0.9, 1.4, 0.5, 1.6},
       -6.231937219330594,
       {0.8662073716431834, -0.8127122004677279, -0.3609030086599166, -0.6383224500089085, 0.2348261005236514},
       {0.5307238585202362, 0.04675366540777681, -0.1672217745465643, 0.184067566337068},
       {-0.2967686549419311, 0.05401182028872498, 1.085166537853962, -0.9755274376866326, 0.5834432363214452,
        -0.208830577945471, 1.045558577825606},
       {0.1755706841030451, 0.1650634445886539, 0.1571882164468414, 0.1976432566523653, 0.1945283687812951,
        0.1788958831470358, 0.2847560578338459},
       -4.815469326390751},
      {"matern_5_2 + linear",
       MeanFunction::zero,
       {0.8, 1.7, 1.3, 0.5, 0.25, 0.3},
       -8.312901501889822,
       {-0.3579128946680148, -0.5789355235473033, -2.012812095878976, -0.05689996442636474, -0.1030814609711797,
        -0.1875267289796878, -0.1369206697872584},
       {0.6147289836832649, 0.2330482334049364, -0.1063140040735198, 1.277123659946528},
       {-0.3001829023212177, 0.1757513328984169, 0.853299838766944, -0.9011557396850299, 0.4869295656566576,
        -0.08903302304996206, 1.08541652228331},
       {0.6940513508892212, 0.7106857242144577, 0.6831734329634942, 0.8970475103583626, 0.9394155580292944,
        0.8019046328121514, 1.375808374513694},
       -6.995023827109734},
      {"se_ard*(periodic + linear)",
       MeanFunction::zero,
       {0.8, 0.5, 0.7, 0.6, 0.3, 1.9, 2.7, 1.1, 0.9, 0.4, 0.7},
       -8.671679755684263,
       {-0.2479785278396644, -0.270721338659629, -2.530680430990725, -0.2729122623400218, -0.136335134400335,
        0.2365254791231177, 0.1253646919748373, -1.445442844963151, -0.4049563110635798, -0.2247149090846387,
        -0.4555663658793555, -0.1213321491359779},
       {0.5999832559222506, 0.2669792758219923, -0.07297596026543224, 1.601131238652528},
       {-0.1098676389140419, -0.09102245628265253, 0.7612194553695359, -0.5712082555648294, 0.5003061426978863,
        -0.1746300552373159, 0.5940511861250969},
       {1.086073930462833, 1.0138227114468, 0.9833303942028088, 1.544040081882311, 1.079123310353372, 1.184136917045959,
        2.100053776209038},
       -7.774596552754193},
      {"se_ard",
       MeanFunction::constant,
       {0.8, 1.7, 1.3},
       -7.872129962918232,
       {0.02996085213723841, -0.873724568782439, -1.423742815762354, -0.07725612870068163},
       {0.6686773407954331, 0.1090872393249821, 0.2145606888458442, 0.7837887118911153},
       {-0.4458316644817646, 0.3457177584099003, 0.8133062826401072, -0.7936671318370836, 0.4013929484984831,
        0.05675441914124452, 0.9885180974353644},
       {0.4833635318597354, 0.476835744507587, 0.4731185803645995, 0.5605856166875421, 0.6284723638563426,
        0.5070943698336319, 0.8180846388764358},
       -6.815700645630595},
      {"matern_3_2",
       MeanFunction::linear,
       {0.8, 1.7, 1.3},
       -6.984572880527686,
       {-0.3930140291278794, -0.3907908745601613, -2.947694259452338, -0.1667811335823794},
       {0.560074476420828, 0.3275405110533581, -0.05753103134852042, 1.023064218274977},
       {-0.229281944838755, 0.1121861431220435, 0.9371050354209914, -0.959473552822245, 0.7819955407363095,
        -0.4362629119172221, 1.349639053381851},
       {0.7747084230616866, 0.7985110952128716, 0.7677563472900164, 0.8685670648825335, 0.890285049100418,
        0.8075469906881276, 1.077513846760826},
       -6.51074208399958},
  };
  return list;
}

VectorXd vector(const std::vector<double>& numbers) {
  return VectorXd::Map(numbers.data(), static_cast<Index>(numbers.size()));
}

// Relative to the greatest of the numbers.
void expect_equal(const VectorXd& found, const std::vector<double>& numbers, const Case& c, const char* what) {
  const VectorXd expected = vector(numbers);
  ASSERT_EQ(found.size(), expected.size()) << c.covariance << " " << what;
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff())
      << c.covariance << " " << what << "\n"
      << found.transpose();
}

TEST(Given, AllThatIsKnownAgreesWithFiftyDigits) {
  MatrixXd probe(2, 2);
  probe << 0.25, -0.40, -0.90, 1.30;
  for (const Case& c : cases()) {
    const GaussianProcess gp(find_covariance(c.covariance), c.mean, {vector(c.theta), noise}, seven_x(), seven_y());
    EXPECT_EQ(gp.jitter(), 0);
    EXPECT_NEAR(gp.log_likelihood(), c.log_likelihood, 1e-12 * std::fabs(c.log_likelihood)) << c.covariance;
    const Likelihood found = gp.likelihood();
    EXPECT_EQ(found.value, gp.log_likelihood());
    expect_equal(found.gradient, c.gradient, c, "gradient");
    const Prediction at = gp.predict(probe);
    expect_equal(Eigen::Vector4d(at.mean[0], at.variance[0], at.mean[1], at.variance[1]), c.predicted, c, "prediction");
    const LeaveOneOut loo = gp.leave_one_out();
    expect_equal(loo.mean, c.mean_of_each, c, "leave-one-out means");
    expect_equal(loo.variance, c.variance_of_each, c, "leave-one-out variances");
    EXPECT_NEAR(loo.log_probability, c.log_probability, 1e-12 * std::fabs(c.log_probability)) << c.covariance;
    EXPECT_NEAR(loo.log_density.sum(), loo.log_probability, 1e-14 * std::fabs(c.log_probability));
  }
}

GpModelOptions given(const std::string& covariance, const std::string& mean, Hyperparameters at) {
  GpModelOptions options;
  options.process.covariance = covariance;
  options.process.mean = mean;
  options.process.max_iterations = 0;
  options.normalise = false;
  options.given = {std::move(at)};
  return options;
}

TEST(Given, NothingIsTrainedWithoutIterations) {
  const Hyperparameters at{vector({0.8, 1.7, 1.3}), noise};
  const GpMapFit fit = fit_gp_map(seven_x(), seven_y(), given("se_ard", "zero", at));
  EXPECT_EQ(fit.model->process(0).hyperparameters().theta, at.theta);
  EXPECT_EQ(fit.model->process(0).hyperparameters().v0, at.v0);
  EXPECT_EQ(fit.report.stopped, "nothing was trained");
  EXPECT_EQ(fit.report.reached, fit.model->log_likelihood(0));
  GpModelOptions some = given("se_ard", "zero", at);
  some.process.max_iterations = 50;
  some.process.starts = 1;
  EXPECT_GT(fit_gp_map(seven_x(), seven_y(), some).report.reached, fit.report.reached);
}

// The same process in other units: densities are per unit of the target, so the likelihood is the same number.
TEST(Given, TheLikelihoodAndLeaveOneOutDoNotDependOnTheNormalisation) {
  const MatrixXd x = (seven_x() * 3).array() + 5, y = (seven_y() * 20).array() - 7;
  const Scaling xs = standard_scaling(x), ys = standard_scaling(y);
  const double sy2 = ys.scale[0] * ys.scale[0];
  const Hyperparameters plain{vector({0.09, 0.2, 500}), 20};
  Hyperparameters between = plain;  // of normalised numbers
  for (Index d = 0; d < 2; ++d) between.theta[d] *= xs.scale[d] * xs.scale[d];
  between.theta[2] /= sy2;
  between.v0 /= sy2;
  GpModelOptions normalised = given("se_ard", "constant", between);
  normalised.normalise = true;
  const auto one = fit_gp_map(x, y, given("se_ard", "constant", plain)).model, two = fit_gp_map(x, y, normalised).model;
  EXPECT_NEAR(one->log_likelihood(0), two->log_likelihood(0), 1e-11);
  EXPECT_LT((one->likelihood(0).gradient - two->likelihood(0).gradient).cwiseAbs().maxCoeff(), 1e-11);
  const LeaveOneOut a = one->leave_one_out(0), b = two->leave_one_out(0);
  EXPECT_LT((a.mean - b.mean).cwiseAbs().maxCoeff(), 1e-11 * a.mean.cwiseAbs().maxCoeff());
  EXPECT_LT((a.variance - b.variance).cwiseAbs().maxCoeff(), 1e-11 * a.variance.maxCoeff());
  EXPECT_NEAR(a.log_probability, b.log_probability, 1e-11);
}

// Where the covariances are singular the likelihood is that with the jitter, and so is its gradient.
TEST(Given, RepeatedPointsWithoutNoiseHaveALikelihoodWithTheJitter) {
  MatrixXd x(8, 2);
  x << seven_x(), seven_x().row(3);
  VectorXd y(8);
  y << seven_y(), seven_y()[3];
  const GaussianProcess gp(find_covariance("se_ard"), MeanFunction::zero, {vector({0.8, 1.7, 1.3}), 0}, x, y);
  EXPECT_GT(gp.jitter(), 0);
  EXPECT_TRUE(std::isfinite(gp.log_likelihood()));
  EXPECT_EQ(gp.likelihood().value, gp.log_likelihood());
  EXPECT_TRUE(gp.likelihood().gradient.allFinite());
  EXPECT_EQ(gp.likelihood().gradient[3], 0);  // by log v0 where v0 is 0
}

TEST(GivenErrors, AreInTheUsersWords) {
  const auto complaint = [](const GpModelOptions& options, const MatrixXd& y) -> std::string {
    try {
      fit_gp_map(seven_x(), y, options);
    } catch (const IdentifyError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint(given("se_ard", "zero", {vector({1, 1}), 0.1}), seven_y()),
            "covariance 'se_ard' with 2 inputs has 3 hyperparameters (w1, w2, v1), but 2 are given");
  EXPECT_EQ(complaint(given("se_ard", "zero", {vector({1, 1, -1}), 0.1}), seven_y()),
            "hyperparameter v1 is -1; it must be greater than 0");
  GpModelOptions three = given("se_ard", "zero", {vector({1, 1, 1}), 0.1});
  three.given.resize(3, three.given[0]);
  EXPECT_EQ(complaint(three, seven_y()), "there are hyperparameters of 3 outputs, the data have 1");
  GpModelOptions trained = given("se_ard", "zero", {vector({1, 1, 1}), 0});
  trained.process.max_iterations = 5;
  EXPECT_EQ(complaint(trained, seven_y()),
            "the noise variance v0 is 0; a fit that begins there needs one greater than 0");
  try {
    GpModelOptions all = given("se_ard", "zero", {vector({1, 1}), 0.1});
    all.most = 20000;
    fit_gp_map(VectorXd::LinSpaced(13000, 0, 1), VectorXd::LinSpaced(13000, 0, 1), all);
    FAIL();
  } catch (const IdentifyError& error) {
    EXPECT_STREQ(error.what(),
                 "an exact process of 13000 points needs about 5 GB; take fewer points, or see all of them through "
                 "inducing inputs, as the approximations fitc and vfe do");
  }
  // Of several outputs the second one.
  MatrixXd two(7, 2);
  two << seven_y(), seven_y();
  two(4, 1) = std::nan("");
  EXPECT_EQ(complaint(given("se_ard", "zero", {vector({1, 1, 1}), 0.1}), two),
            "the target in row 5 is nan, not a finite number");
}

}  // namespace
}  // namespace plantloop::identify
