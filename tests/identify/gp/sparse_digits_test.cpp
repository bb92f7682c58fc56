// FITC and the variational bound against arithmetic of 40 digits (explicit inverses, determinants and derivatives of a
// multiple-precision library), and against the exact process.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "identify/gp/gaussian_process.h"
#include "identify/gp/sparse.h"
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
MatrixXd three_inducing() {
  MatrixXd u(3, 2);
  u << -0.80, -0.60, 0.20, 0.40, 1.10, -0.05;
  return u;
}
constexpr double noise = 0.05;

struct Case {
  std::string covariance;
  SparseMethod method;
  MeanFunction mean;
  std::vector<double> theta;
  double log_likelihood;
  std::vector<double> gradient;      // by log theta and log v0
  std::vector<double> by_inducing;   // row by row
  std::vector<double> predicted;     // mean and variance at two points
  std::vector<double> mean_of_each;  // leave-one-out
  std::vector<double> variance_of_each;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> list{
      {"se_ard",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -7.560527705853323,
       {-0.2373328277980733, -1.234463654439829, -1.7538954810476, -0.1921198660933807},
       {-0.3456283763107634, 0.8215213055221601, 0.03724017671181134, 0.613891539615203, 0.02256020142019813,
        -0.06425266963675679},
       {0.3036813931635216, 0.4485611709163267, 0.026821563920375, 1.158912227137491},
       {-0.1783832288166355, 0.1804925608070484, 0.8016812374107132, -0.5922680353475149, 0.243654236582423,
        -0.3384663245188146, 0.7805603922583388},
       {0.6432707166051705, 0.5318588703234138, 0.5074997440254736, 0.6345314431617252, 0.840767545032196,
        0.6017672684286062, 0.765231566668691}},
      {"se_ard",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -33.33191763646734,
       {-9.989657716664563, -20.48396107047516, -25.65530529994224, 28.66200069367094},
       {2.547958914455071, 0.04903030886724407, 0.8591953167773095, 13.6371745410649, -0.8059159741906789,
        -7.778925359260746},
       {0.388977118164117, 0.3754675775410417, 0.06043159787073427, 1.1342946722561},
       {-0.2520282990858114, 0.3008064563283629, 1.108453268962471, -0.6599337332071667, 0.256446032425057,
        -0.4999497791943019, 1.410082636571939},
       {0.5459075648134478, 0.3346822464274989, 0.3462051178218491, 0.5188964385417701, 0.7479625782809862,
        0.3671165526587984, 0.3350760646820688}},
      {"matern_3_2",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -8.284111816694656,
       {-0.05037210345349447, -0.7649039279160999, -1.863351520524978, -0.1262977974966611},
       {-0.2486689434510467, 0.3582983036472991, 0.01778843052992003, 0.3481705445893438, 0.152680308660289,
        0.0616620853647705},
       {0.2593487295049501, 0.785833067648965, 0.06142913148411003, 1.236347920495545},
       {-0.1448810740421669, 0.2399808977102437, 0.5740700533977476, -0.3742056750850455, 0.224976109563562,
        -0.2065076729600705, 0.4818766651762547},
       {0.9447491506421494, 0.8750822883755699, 0.8319492416964957, 0.9305032273933243, 1.104036452006873,
        0.9056354463068237, 1.06955943775814}},
      {"matern_3_2",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -51.84758973089769,
       {-8.361065993732227, -19.70268181401977, -43.28200292420486, 47.28555235806808},
       {-0.1891093530004751, -6.212161637815195, -1.144659579429469, 12.95805303543274, 5.094687299828303,
        -9.720788307132763},
       {0.3612658266292299, 0.6784367315708295, 0.08124753009972725, 1.211649578489758},
       {-0.2594222304626186, 0.3658842977073064, 0.9954476944891657, -0.5920970658110816, 0.2655238091987515,
        -0.4902188352804277, 1.54285237561882},
       {0.8197332914466115, 0.6355617217431712, 0.5842868885604628, 0.7693236130469217, 1.000190021998231,
        0.601650676083167, 0.6303329354592376}},
      {"matern_5_2",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -8.065260138064678,
       {-0.1135149927936169, -0.9282987624248312, -1.844485326298251, -0.1440931154219992},
       {-0.2930232814459544, 0.4982632702128277, 0.001942331775658841, 0.4543206197211532, 0.1279096328998754,
        0.03024394392234947},
       {0.2784341251253091, 0.676925278239895, 0.05149912458171554, 1.220106018909964},
       {-0.1659710924426448, 0.2241167025919065, 0.6557709475084765, -0.4569952644742461, 0.2306047204797934,
        -0.2572657017220902, 0.5799086420749297},
       {0.8491834453024339, 0.7596799687971241, 0.7160469543698735, 0.8286586592098159, 1.030487279333561,
        0.796864381091556, 0.985622070793958}},
      {"matern_5_2",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.8, 1.7, 1.3},
       -45.1879459870144,
       {-9.44112544901801, -20.61672715771758, -36.88432123613267, 40.60412978473969},
       {0.7396802341045071, -4.211279318968588, -0.8634371232608594, 13.97331537108209, 3.52868504904494,
        -9.422467205845226},
       {0.374584854735629, 0.5804979511375243, 0.07412822648339049, 1.196187718901765},
       {-0.2613951551435918, 0.3493177967269099, 1.03410158542367, -0.6124209011024924, 0.2563600175510826,
        -0.491213051161898, 1.517673588485525},
       {0.7323708978702344, 0.5246877679477896, 0.4886425962134232, 0.6794171224076862, 0.9283719587863035,
        0.5048456160453348, 0.5138136027214127}},
      {"rational_quadratic",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.8, 1.7, 1.3, 0.6},
       -7.674828943097685,
       {0.1072837546986013, -1.004514040149838, -1.283956290082081, 0.09486814923328246, -0.1737414829423225},
       {-0.5396237763010631, 0.7486500171308317, 0.01138463147838267, 0.5595761544367359, 0.1965819908183825,
        0.05302715461403616},
       {0.2695073014531108, 0.415355394836278, 0.1131080306416044, 0.9766692506243286},
       {-0.1480316081699643, 0.2229822873110434, 0.688574938602807, -0.4524361535691104, 0.3299269984748795,
        -0.2038286362578344, 0.6508596261535082},
       {0.5624024199426111, 0.5054643512055884, 0.4823837335938326, 0.5727966966170108, 0.7716702003833042,
        0.5636455816674711, 0.7176872201091722}},
      {"rational_quadratic",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.8, 1.7, 1.3, 0.6},
       -31.99784154745746,
       {-5.231245974142895, -14.74539062487576, -23.7506013683963, -2.019204171939514, 27.05952778914607},
       {-1.097110424205993, -4.599049594967417, -1.023799334802826, 11.46806852050104, 2.707289573222852,
        -6.611858130534308},
       {0.3387051070541793, 0.3592503933004677, 0.1416890693205166, 0.9399338034137667},
       {-0.2323078126311641, 0.2721098270676765, 0.9997737805567266, -0.6088318984457562, 0.3629970107485214,
        -0.4370347687494357, 1.507143251885662},
       {0.4838966000387079, 0.3547126290371542, 0.3341936261504662, 0.4658078592781167, 0.6859558494798564,
        0.3590076423234259, 0.4024817793639783}},
      {"linear",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.9, 0.4, 0.7},
       -6.336072500318589,
       {-0.1769232779557643, -0.3475816040271819, -0.47289511323086, 1.732636609736356},
       {-8.552847072295026e-49, -4.704065889762264e-49, 2.138211768073757e-49, 1.282927060844254e-49,
        1.026341648675403e-48, 1.282927060844254e-49},
       {0.2346093604581662, 0.01037624975079255, -0.08239826651484321, 0.05406678244016012},
       {-0.1455265348722839, -0.03250482892282793, 0.9712841268291646, -0.9481990868848058, 0.7956393082391526,
        -0.292994461390977, 1.286020224903488},
       {0.07137659570904475, 0.06678496912813924, 0.0718953287500262, 0.09207747694077001, 0.1056131727448804,
        0.09263185888514853, 0.1380412959546775}},
      {"linear",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.9, 0.4, 0.7},
       -6.336072500318589,
       {-0.1769232779557643, -0.3475816040271819, -0.47289511323086, 1.732636609736356},
       {-2.993496475303259e-49, 5.131708243377016e-49, -1.710569414459005e-49, 2.993496475303259e-49,
        1.282927060844254e-49, 8.552847072295026e-50},
       {0.2346093604581662, 0.01037624975079255, -0.08239826651484321, 0.05406678244016012},
       {-0.1455265348722839, -0.03250482892282793, 0.9712841268291646, -0.9481990868848058, 0.7956393082391526,
        -0.292994461390977, 1.286020224903488},
       {0.07137659570904475, 0.06678496912813924, 0.0718953287500262, 0.09207747694077001, 0.1056131727448804,
        0.09263185888514853, 0.1380412959546775}},
      {"periodic",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.6, 0.3, 1.9, 2.7, 1.1},
       -9.239521576387713,
       {0.5007702915970315, -0.07994231411582841, -6.371113152046903, 0.4590051665623942, -0.448605697007495,
        0.008444728252701739},
       {-3.590516025278676, 0.2536933087415447, -0.2937094015499442, 0.2130151993432638, 0.6688000184770424,
        0.1053346355411576},
       {0.3359756434695707, 0.7306821444060126, -0.2861328597233199, 0.714955959142306},
       {0.161525790068878, 0.3126508819847987, 0.0745562324473742, 0.2221187800211774, 0.2277745689974614,
        0.2852640349034758, -0.2020389564390601},
       {0.9024714487989148, 0.8037235701948841, 0.8082663187020154, 0.7443612830672942, 0.9081479620942509,
        0.8439741736069796, 0.7763766829788438}},
      {"periodic",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.6, 0.3, 1.9, 2.7, 1.1},
       -68.29256087237309,
       {-17.28986403225672, -12.24452309856296, -53.68508882868514, 24.06340062784647, -39.60454310993543,
        64.52561819005653},
       {-25.48978522088401, -9.258575444210047, -6.760320176712559, 5.79361555335622, 26.73897650253348,
        2.548754016198314},
       {0.5974427441260746, 0.5832303532598356, -0.3950867289729824, 0.6323823754843059},
       {0.3619273781240451, 0.7028467577763629, 0.2166006394517712, 0.4356436243275527, 0.6067830515906676,
        0.614328533720927, -0.2618434404230385},
       {0.773782944016233, 0.6601693175103292, 0.6900650865500347, 0.6409829456667635, 0.6778895417987054,
        0.5601020026458292, 0.6889225781417491}},
      {"neural_network",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.9, 1.4, 0.5, 1.6},
       -5.778705898255954,
       {0.3680534876119307, -0.6995253222562637, -0.2263509737235073, -0.8773058126852424, -0.2329729274800207},
       {-0.8169761087505696, 1.101673781775395, -0.09028370741533547, 0.620533240455772, 0.05053405616101804,
        -0.1143364613829279},
       {0.2703692985318649, 0.1334824975156254, -0.0573556998110006, 0.3557522659693251},
       {-0.1560754398423896, -0.08181096826705982, 1.092241656041805, -0.9343124859445524, 0.6550024205776384,
        -0.3060939833660646, 0.9074157084024647},
       {0.2454643468594824, 0.2005340610904315, 0.1648293980107697, 0.2295715949361406, 0.2418313159842389,
        0.210908603759452, 0.240500105436904}},
      {"neural_network",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.9, 1.4, 0.5, 1.6},
       -12.08047919431352,
       {-1.725284143417993, -3.266827073728455, -1.030726573731667, -6.22376644373075, 7.747006265587119},
       {2.081453779916257, -1.553752351378081, -0.8371043394906056, 4.51309426551011, -0.6056582412349624,
        -2.987565436531939},
       {0.3400350307716604, 0.1150838128342218, -0.06259205069927985, 0.3191221619209266},
       {-0.1743622832401007, -0.02698657277685619, 1.131376938327753, -0.9189496093885955, 0.6436238261221249,
        -0.2987895036434781, 1.11290854986539},
       {0.2208555692791928, 0.1569922024049946, 0.1309862212327129, 0.1924822128118649, 0.1952358545956637,
        0.1409897144931796, 0.1402901729663297}},
      {"matern_5_2 + linear",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.8, 1.7, 1.3, 0.5, 0.25, 0.3},
       -8.388151879394356,
       {-0.3804185606896814, -0.7519965899635575, -2.103969870315983, -0.1074783287655184, -0.1489391862947587,
        -0.1952842254106021, -0.1456432192425961},
       {-0.1767742428226884, 0.2484102529182341, -0.06837498476793163, 0.6327319807520607, 0.2712954684972855,
        0.005365854619713003},
       {0.2585491302996375, 0.6932448237357247, -0.1794573497991505, 1.981403304060458},
       {-0.1134960535459279, 0.07203754327327604, 0.8062434444298749, -0.7634115771518466, 0.4159294774236138,
        -0.291316588178163, 0.9733666225602975},
       {0.9193133798714926, 0.8300629467987798, 0.8034280144877009, 1.046442990930189, 1.31005632640625,
        0.9326707910143288, 1.358197690035707}},
      {"matern_5_2 + linear",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.8, 1.7, 1.3, 0.5, 0.25, 0.3},
       -49.404387595363,
       {-13.30348293074344, -19.79091904401705, -39.28979064761725, -1.133501193316297, -2.01264703815756,
        -0.8761973201870812, 44.71352059749843},
       {1.295953476610814, -7.1314300530074, -1.924000692332941, 20.02419628335736, 9.801163845283956,
        -9.461833702910386},
       {0.324496206438356, 0.5894150785736222, -0.159002810819604, 1.885090358477887},
       {-0.1531818385323272, 0.1828180564344796, 1.058753726042634, -0.8647530079909053, 0.4745416309922525,
        -0.3911947954383202, 1.473807596699727},
       {0.7779005560634301, 0.5455408032528653, 0.5196368701509849, 0.8060099163744643, 1.148974405215149,
        0.5534449517249414, 0.5537233191164143}},
      {"se_ard*(periodic + linear)",
       SparseMethod::fitc,
       MeanFunction::zero,
       {0.8, 0.5, 0.7, 0.6, 0.3, 1.9, 2.7, 1.1, 0.9, 0.4, 0.7},
       -8.595027760440479,
       {-0.2007500941250479, -0.2657910276828378, -2.597323608677363, -0.3196285541679029, -0.2258806904074963,
        0.4635823119875739, 0.33603498408994, -1.49151867375886, -0.3966163522148659, -0.2360218346226217,
        -0.4731667480810151, -0.123775121689188},
       {0.01864019061117544, 0.1536214701437783, 0.08053958063657376, 0.1698595272085907, 0.0009683773805509679,
        0.1704613223315878},
       {0.3392699941589313, 0.872378725155766, -0.1342167160052845, 2.084576718925411},
       {0.0683496881338234, -0.08093466145272338, 0.7367003232331955, -0.657618094201218, 0.4095455907505404,
        -0.3311810657037026, 0.6166477832175676},
       {1.120256077654311, 1.036057974774965, 1.084655142682722, 1.378436506422938, 1.324482103854545,
        1.061556240749305, 1.956882793274258}},
      {"se_ard*(periodic + linear)",
       SparseMethod::vfe,
       MeanFunction::zero,
       {0.8, 0.5, 0.7, 0.6, 0.3, 1.9, 2.7, 1.1, 0.9, 0.4, 0.7},
       -61.98894482171634,
       {-6.437117442448927, -8.542140418504096, -58.69618014717838, -12.39501413718712, -8.316636016712618,
        19.6558056413409, 12.29108785551232, -37.83720185998307, -8.5549395360616, -5.638085485757915,
        -6.66595326537579, 57.56548623903987},
       {3.379259966602179, -1.956723173256614, 5.40323658828833, 10.16595026387385, 22.79793092384362,
        -1.597716293730614},
       {0.4944649834743087, 0.7308327406571184, -0.125289802712084, 2.041126538474777},
       {0.144987104041537, -0.01120033672918337, 1.102497603291354, -0.8341051330740494, 0.6946795876712175,
        -0.6593929153688456, 0.8668175147478137},
       {1.027307317530822, 0.9013008400826714, 0.7702692656912659, 1.167941613760737, 0.9602737953679636,
        0.5167705484956315, 1.179065103909905}},
      {"se_ard",
       SparseMethod::fitc,
       MeanFunction::constant,
       {0.8, 1.7, 1.3},
       -7.492735627004236,
       {-0.2071971518831909, -1.176895792232134, -1.822523344237325, -0.1912840817527432},
       {-0.4651298198167211, 0.9487779048982513, 0.06211828879268463, 0.7051048257093948, -0.01749046998162367,
        -0.06767169986278226},
       {0.2508274341639577, 0.4485611709163267, 0.2258964857265754, 1.158912227137491},
       {-0.1877587155206986, 0.1803171630860048, 0.8079243873109884, -0.5419595343966629, 0.3813296083497063,
        -0.2572803629984543, 0.9028474551946486},
       {0.6432707166051705, 0.5318588703234138, 0.5074997440254736, 0.6345314431617252, 0.840767545032196,
        0.6017672684286062, 0.765231566668691}},
      {"matern_3_2",
       SparseMethod::vfe,
       MeanFunction::linear,
       {0.8, 1.7, 1.3},
       -47.86489308707493,
       {-13.06702740147099, -12.91706266338018, -44.66779561276868, 44.68864840280913},
       {5.297763784641797, -2.871544931137843, -1.64078587342281, 12.725353816608, 6.854345608152514,
        -8.378800097742349},
       {0.2695474176934728, 0.6784367315708295, 0.01832698051836001, 1.211649578489758},
       {-0.1448759377511926, -0.05374621181086012, 0.9862316482751396, -0.7752252456072141, 0.7932309989546814,
        -0.3863990923640114, 1.564574350087898},
       {0.8197332914466115, 0.6355617217431712, 0.5842868885604628, 0.7693236130469217, 1.000190021998231,
        0.601650676083167, 0.6303329354592376}},
  };
  return list;
}

VectorXd vector(const std::vector<double>& numbers) {
  return VectorXd::Map(numbers.data(), static_cast<Index>(numbers.size()));
}

// Relative to the greatest of the numbers, or to 1.
void expect_equal(const VectorXd& found, const std::vector<double>& numbers, const Case& c, const char* what) {
  const VectorXd expected = vector(numbers);
  ASSERT_EQ(found.size(), expected.size()) << c.covariance << " " << what;
  EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 1e-11 * std::max(1.0, expected.cwiseAbs().maxCoeff()))
      << c.covariance << " " << name_of(c.method) << " " << what << "\n"
      << found.transpose();
}

TEST(SparseDigits, AllThatIsKnownAgreesWithFortyDigits) {
  MatrixXd probe(2, 2);
  probe << 0.25, -0.40, -0.90, 1.30;
  for (const Case& c : cases()) {
    const SparseGaussianProcess gp(c.method, find_covariance(c.covariance), c.mean, {vector(c.theta), noise}, seven_x(),
                                   seven_y(), three_inducing());
    EXPECT_EQ(gp.jitter(), 0) << c.covariance;
    EXPECT_NEAR(gp.log_likelihood(), c.log_likelihood, 1e-11 * std::fabs(c.log_likelihood)) << c.covariance;
    const Likelihood found = gp.likelihood();
    EXPECT_EQ(found.value, gp.log_likelihood());
    expect_equal(found.gradient, c.gradient, c, "gradient");
    expect_equal(found.by_inducing.transpose().reshaped(), c.by_inducing, c, "gradient by the inducing inputs");
    const Prediction at = gp.predict(probe);
    expect_equal(Eigen::Vector4d(at.mean[0], at.variance[0], at.mean[1], at.variance[1]), c.predicted, c, "prediction");
    EXPECT_LT((gp.predict_mean(probe) - at.mean).norm(), 1e-14);
    const LeaveOneOut loo = gp.leave_one_out();
    expect_equal(loo.mean, c.mean_of_each, c, "leave-one-out means");
    expect_equal(loo.variance, c.variance_of_each, c, "leave-one-out variances");
    EXPECT_NEAR(loo.log_probability, log_densities(seven_y(), loo.mean, loo.variance).sum(), 1e-13);
  }
}

// With U = all inputs Q = K_ff: likelihood, gradient, predictions and leave-one-out are those of the exact process.
TEST(SparseDigits, WithAllInputsInducingItIsTheExactProcessOfEveryCovariance) {
  const MatrixXd x = random_points(25, 2, 61), probe = random_points(10, 2, 62);
  const VectorXd y = first_order_targets(x, 0.1, 63);
  std::vector<std::string> texts{"se_ard*(periodic + linear)", "matern_3_2 + linear"};
  for (const CovarianceType& type : covariances()) texts.emplace_back(type.name);
  for (const std::string& text : texts) {
    const auto form = find_covariance(text);
    for (const MeanFunction mean : {MeanFunction::zero, MeanFunction::linear}) {
      if (mean == MeanFunction::linear && text == "linear") continue;
      const Hyperparameters at{random_positive(form->count(2), 64), 0.05};
      const GaussianProcess full(form, mean, at, x, y);
      for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
        const SparseGaussianProcess sparse(method, form, mean, at, x, y, x);
        EXPECT_NEAR(sparse.log_likelihood(), full.log_likelihood(), 1e-8) << text;
        const VectorXd gradient = full.likelihood().gradient;
        EXPECT_LT((sparse.likelihood().gradient - gradient).cwiseAbs().maxCoeff(),
                  1e-8 * std::max(1.0, gradient.cwiseAbs().maxCoeff()))
            << text << " " << name_of(method);
        const Prediction a = sparse.predict(probe), b = full.predict(probe);
        EXPECT_LT((a.mean - b.mean).cwiseAbs().maxCoeff(), 1e-8) << text;
        EXPECT_LT((a.variance - b.variance).cwiseAbs().maxCoeff(), 1e-8) << text;
        const LeaveOneOut c = sparse.leave_one_out(), d = full.leave_one_out();
        EXPECT_LT((c.mean - d.mean).cwiseAbs().maxCoeff(), 1e-8) << text;
        EXPECT_LT((c.variance - d.variance).cwiseAbs().maxCoeff(), 1e-8) << text;
      }
    }
  }
}

// log N(y; 0, Q + G), of the bound minus tr(K_ff - Q)/(2 v0), by matrices of N x N.
TEST(SparseDigits, TheLikelihoodIsThatOfTheDenseMatrix) {
  const MatrixXd x = random_points(200, 2, 71), u = random_points(15, 2, 72);
  const VectorXd y = first_order_targets(x, 0.05, 73);
  for (const char* text : {"se_ard", "matern_5_2 + linear", "neural_network"}) {
    const auto form = find_covariance(text);
    const Hyperparameters at{random_positive(form->count(2), 74), 0.01};
    const MatrixXd kuf = form->between(at.theta, u, x);
    const MatrixXd q = kuf.transpose() * form->between(at.theta, u, u).fullPivLu().solve(kuf);
    const VectorXd missed = form->at(at.theta, x) - q.diagonal();
    for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
      MatrixXd c = q;
      c.diagonal().array() += at.v0;
      if (method == SparseMethod::fitc) c.diagonal() += missed;
      const Eigen::PartialPivLU<MatrixXd> lu(c);
      double expected = -0.5 * y.dot(lu.solve(y)) - 0.5 * lu.matrixLU().diagonal().array().abs().log().sum() -
                        100 * std::log(2 * std::acos(-1.0));
      if (method == SparseMethod::vfe) expected -= missed.sum() / (2 * at.v0);
      const SparseGaussianProcess sparse(method, form, MeanFunction::zero, at, x, y, u);
      EXPECT_NEAR(sparse.log_likelihood(), expected, 1e-8 * std::fabs(expected)) << text << " " << name_of(method);
    }
    // It is a lower bound of the exact one.
    EXPECT_LT(SparseGaussianProcess(SparseMethod::vfe, form, MeanFunction::zero, at, x, y, u).log_likelihood(),
              GaussianProcess(form, MeanFunction::zero, at, x, y).log_likelihood());
  }
}

template <typename F>
double difference(F f, double h) {  // order 8
  return (672 * (f(h) - f(-h)) - 168 * (f(2 * h) - f(-2 * h)) + 32 * (f(3 * h) - f(-3 * h)) -
          3 * (f(4 * h) - f(-4 * h))) /
         (840 * h);
}

TEST(SparseDigits, TheGradientIsThatOfDifferences) {
  const MatrixXd x = random_points(60, 3, 81), u = random_points(8, 3, 82);
  const VectorXd y = first_order_targets(x, 0.1, 83);
  std::vector<std::string> texts{"se_ard*(periodic + linear)", "matern_3_2 + neural_network"};
  for (const CovarianceType& type : covariances()) texts.emplace_back(type.name);
  for (const std::string& text : texts) {
    const auto form = find_covariance(text);
    const Hyperparameters at{random_positive(form->count(3), 84), 0.05};
    for (const SparseMethod method : {SparseMethod::fitc, SparseMethod::vfe}) {
      for (const MeanFunction mean : {MeanFunction::zero, MeanFunction::constant}) {
        const auto value = [&](const Hyperparameters& there, const MatrixXd& inducing) {
          return sparse_likelihood(method, *form, mean, there, x, y, inducing, false).value;
        };
        const Likelihood found = sparse_likelihood(method, *form, mean, at, x, y, u);
        EXPECT_EQ(found.value, value(at, u));
        const double scale =
            std::max({1.0, found.gradient.cwiseAbs().maxCoeff(), found.by_inducing.cwiseAbs().maxCoeff()});
        // Of `linear` K_uu is singular and has a jitter of 1e-12, which rounding of 1e-16 makes 1e-4 of.
        const double enough = (text == "linear" ? 1e-4 : 1e-8) * scale;
        for (Index p = 0; p < found.gradient.size(); ++p) {
          const double expected = difference(
              [&](double h) {
                Hyperparameters moved = at;
                (p < at.theta.size() ? moved.theta[p] : moved.v0) *= std::exp(h);
                return value(moved, u);
              },
              1e-3);
          EXPECT_NEAR(found.gradient[p], expected, enough) << text << " " << name_of(method) << " " << p;
        }
        for (Index i = 0; i < u.rows(); i += 3) {
          for (Index d = 0; d < 3; ++d) {
            const double expected = difference(
                [&](double h) {
                  MatrixXd moved = u;
                  moved(i, d) += h;
                  return value(at, moved);
                },
                1e-3);
            EXPECT_NEAR(found.by_inducing(i, d), expected, enough) << text << " " << name_of(method) << " " << i;
          }
        }
      }
    }
  }
}

}  // namespace
}  // namespace plantloop::identify
