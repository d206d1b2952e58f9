// The friction that holds between two bodies.
#include "sim/contact/pair_friction.h"

#include "sim/case/case_reader.h"
#include "sim/scene/awake_scene.h"
#include "sim/view/scene_description.h"
#include "tests/sim/simulated_case.h"

namespace weft::sim::pair_friction_test {
namespace {

std::string body(const std::string& name, const std::string& more = "") {
  return "[[body]]\nname = \"" + name + "\"\nmaterial = \"silk\"\n" + more +
         "shape = { type = \"rectangle\", size = [1, 1], resolution = [3, 3] }\n"
         "position = [0, 0, " +
         std::to_string(name.size()) + "]\n";
}
std::string obstacle(const std::string& name, const std::string& more) {
  return "[[obstacle]]\nname = \"" + name + "\"\n" + more +
         "shape = { type = \"sphere\", radius = 0.1, resolution = [5] }\n";
}
std::string pair(const std::string& names, const std::string& friction) {
  return "[[contact.pair]]\nbetween = [" + names + "]\nfriction = " + friction + '\n';
}

// Two bodies of silk, one of which does not touch itself, a body of silk that is held as a whole,
// an obstacle of wood and one without a material.
std::string scene_with(const std::string& pairs) {
  return "[contact]\nfriction = 0.1\n[material.silk]\n[material.wood]\n" + body("one") +
         body("other", "self_contact = false\n") + body("table_cloth") +
         "[[body.pin]]\nrows = [0, -1]\n" + obstacle("post", "material = \"wood\"\n") +
         obstacle("ball", "") + pairs;
}

std::unique_ptr<const Scene> scene_of(const std::string& pairs) {
  return build_scene(parse_case(scene_with(pairs), "test.toml"));
}

double between(const Scene& scene, const PairFriction& friction, const std::string& one,
               const std::string& other) {
  const auto index = [&](const std::string& name) {
    const auto found = std::ranges::find(scene.bodies, name, &SceneBody::name);
    return static_cast<int>(found - scene.bodies.begin());
  };
  return friction.of(index(one), index(other));
}

TEST(PairFriction, IsContactFrictionWithoutPairs) {
  const auto scene = scene_of("");
  PairFriction friction(*scene);
  EXPECT_EQ(between(*scene, friction, "one", "post"), 0.1);
  EXPECT_TRUE(friction.any());
  friction.set_default(0);
  EXPECT_FALSE(friction.any());
  EXPECT_EQ(between(*scene, friction, "one", "post"), 0);
}

TEST(PairFriction, OfNamesPrecedesThatOfMaterials) {
  for (const bool names_first : {true, false}) {
    const std::string names = pair("\"one\", \"post\"", "0.2") + pair("\"other\", \"one\"", "0.3");
    const std::string materials =
        pair("\"silk\", \"wood\"", "0.4") + pair("\"silk\", \"silk\"", "0.5");
    const auto scene = scene_of(names_first ? names + materials : materials + names);
    PairFriction friction(*scene);
    friction.set_default(0.6);
    const auto of = [&](const char* one, const char* other) {
      return between(*scene, friction, one, other);
    };
    EXPECT_EQ(of("one", "post"), 0.2);
    EXPECT_EQ(of("one", "other"), 0.3);
    EXPECT_EQ(of("other", "one"), 0.3);
    EXPECT_EQ(of("other", "post"), 0.4);
    EXPECT_EQ(of("one", "one"), 0.5);
    EXPECT_EQ(of("one", "table_cloth"), 0.5);
    EXPECT_EQ(of("one", "ball"), 0.6);
    // "silk" and "silk": two bodies with the held one, and "one" with itself.
    EXPECT_EQ(friction.uses(), names_first ? (std::vector{1, 1, 1, 3}) : (std::vector{1, 3, 1, 1}));
  }
}

TEST(PairFriction, IsFoundWhereOnlyPairsHaveIt) {
  const auto scene = scene_of(pair("\"one\", \"ball\"", "0.2"));
  PairFriction friction(*scene);
  friction.set_default(0);
  EXPECT_TRUE(friction.any());
  EXPECT_EQ(between(*scene, friction, "one", "ball"), 0.2);
  EXPECT_EQ(between(*scene, friction, "other", "ball"), 0);
  // A pair without bodies that may touch gives no friction.
  const auto unused =
      scene_of(pair("\"wood\", \"wood\"", "0.2") + pair("\"other\", \"other\"", "0.2"));
  PairFriction nothing(*unused);
  nothing.set_default(0);
  EXPECT_FALSE(nothing.any());
}

// Bodies that sleep have other indices than before.
TEST(PairFriction, IsThatOfItsNamesWhileABodySleeps) {
  const auto whole =
      scene_of(pair("\"one\", \"other\"", "0.2") + pair("\"other\", \"post\"", "0.3") +
               pair("\"other\", \"ball\"", "0.4"));
  const std::vector<char> asleep{1, 0};
  const AwakeScene awake(*whole, asleep,
                         std::span(whole->initial_position).first(whole->dynamic_particles));
  const Scene& scene = awake.scene();
  ASSERT_EQ(scene.dynamic_bodies, 1);
  ASSERT_EQ(scene.bodies[0].name, "other");
  const PairFriction friction(scene);
  EXPECT_EQ(between(scene, friction, "other", "one"), 0.2);
  EXPECT_EQ(between(scene, friction, "other", "post"), 0.3);
  EXPECT_EQ(between(scene, friction, "other", "ball"), 0.4);
}

TEST(PairFriction, AllowsTheChannelOfFriction) {
  const std::string channel = "[output]\nchannels = [\"friction_force\"]\n";
  const Overrides without{"contact.friction=0"};
  const std::string rough = scene_with(pair("\"one\", \"post\"", "0.2"));
  EXPECT_NO_THROW(parse_case(channel + rough, "test.toml", without));
  const std::string smooth = scene_with(pair("\"one\", \"post\"", "0"));
  EXPECT_THROW(parse_case(channel + smooth, "test.toml", without), CaseError);
}

TEST(PairFriction, IsDescribed) {
  const auto scene = build_scene(
      parse_case(scene_with(pair("\"one\", \"post\"", "0.2") + pair("\"silk\", \"wood\"", "0") +
                            pair("\"wood\", \"wood\"", "0.3")),
                 "test.toml", {"contact.friction=0"}));
  const std::string text = describe_scene(*scene);
  for (const char* part :
       {"  friction 0.2 of \"one\" and \"post\", 1 pair of bodies\n",
        "  skipped friction of \"silk\" and \"wood\": it is 0\n",
        "  skipped friction of \"wood\" and \"wood\": no bodies that may touch have this pair\n",
        "  skipped friction of other pairs: contact.friction is 0\n"})
    EXPECT_NE(text.find(part), std::string::npos) << part << text;
}

TEST(PairFriction, OfParticlesIsNotDescribedAsSkipped) {
  const std::string ball =
      "[[particles]]\nname = \"ball\"\nradius = 0.1\nfriction = 0.4\n"
      "positions = { type = \"grid\", count = [1, 1, 1] }\n";
  const auto described = [&](const Overrides& overrides) {
    return describe_scene(*build_scene(parse_case(ball, "test.toml", overrides)));
  };
  EXPECT_EQ(described({}).find("skipped friction"), std::string::npos);
  EXPECT_NE(described({"particles.ball.friction=0"}).find("skipped friction"), std::string::npos);
}

// The text of a run has the material of an obstacle only if the case gives one, so that the hash of
// other cases stays as it was.
TEST(PairFriction, MaterialOfAnObstacleIsWrittenIfGiven) {
  const std::string text = parse_case(scene_with(""), "test.toml").resolved_text;
  const auto post = text.find("name = \"post\""), ball = text.find("name = \"ball\"");
  ASSERT_LT(post, ball);
  EXPECT_NE(text.substr(post, ball - post).find("material = \"wood\""), std::string::npos);
  EXPECT_EQ(text.substr(ball).find("material"), std::string::npos);
  EXPECT_EQ(parse_case(text, "again.toml").obstacle[0].material, "wood");
}

}  // namespace
}  // namespace weft::sim::pair_friction_test
