// Materials of cloth and seams that must be refused, with place and hint.
#include "sim/case/case_error.h"
#include "sim/scene/scene.h"
#include "tests/sim/bad_case.h"

namespace weft::sim::bad_cloth_test {

namespace {

// Returns a case with these keys of the material, from line 2 on.
std::string cloth(const std::string& keys) { return "[material.cloth]\n" + keys + sheet; }

// Two sheets of 5 x 9 vertices side by side, and a seam with these keys, from line 13 on.
std::string sewn(const std::string& keys) {
  return sheet + R"([[body]]
name = "other"
material = "cloth"
position = [1, 0, 0]
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
[material.cloth]
[[seam]]
)" + keys;
}

// Lists one case per row: its name, the text, the whole message.
std::vector<BadCase> bad_cloth() {
  return {
      {"loss_factor_of_nothing", cloth("loss_factor = 0\nloss_frequency = 10\n"),
       R"(case.toml:2:15: "loss_factor" is 0
  expected a number > 0)"},
      {"loss_factor_without_frequency", cloth("loss_factor = 0.1\n"),
       R"(case.toml:2:15: a loss_factor without the frequency at which it holds
  expected loss_frequency (Hz) with it)"},
      {"frequency_without_loss_factor", cloth("loss_frequency = 10\n"),
       R"(case.toml:2:18: a loss_frequency without a loss_factor
  expected loss_factor with it)"},
      {"loss_factor_beside_damping",
       cloth("loss_factor = 0.1\nloss_frequency = 10\nbending_damping = 1e-3\n"),
       R"(case.toml:4:1: "bending_damping" does not go with "loss_factor"
  expected only one of the two)"},
      {"strain_limit_of_zero", cloth("strain_limit = 0\n"),
       R"(case.toml:2:16: "strain_limit" is 0
  expected a number > 0)"},
      {"strain_limit_without_stiffness", cloth("strain_limit = 0.1\nmembrane_stiffness = 0\n"),
       R"(case.toml:2:16: a strain_limit of a membrane without stiffness
  expected membrane_stiffness > 0 in [material.cloth])"},
      {"strain_limit_of_slack_curves",
       cloth("strain_limit = 0.1\n[material.cloth.orthotropic_membrane]\nwarp_curve = { strains = "
             "[0, 1], tensions = [0, 0] }\nweft_curve = { strains = [0, 1], tensions = [0, 0] }\n"
             "shear_modulus = 10\n"),
       R"(case.toml:2:16: a strain_limit of a membrane without stiffness
  expected membrane_stiffness > 0 in [material.cloth])"},
      {"crease_of_woven_bending",
       cloth("yield_curvature = 100\n[material.cloth.orthotropic_bending]\nwarp = [1e-4]\nbias = "
             "[1e-4]\nweft = [1e-4]\n"),
       R"(case.toml:2:19: a yield_curvature beside orthotropic_bending: creases are of isotropic bending
  expected bending_stiffness in place of orthotropic_bending in [material.cloth])"},
      {"crease_without_bending", cloth("yield_curvature = 100\n"),
       R"(case.toml:2:19: a yield_curvature of a material that does not resist bending
  expected bending_stiffness > 0 in [material.cloth])"},
      {"hardening_without_yield", cloth("bending_stiffness = 1e-4\nhardening = 0.5\n"),
       R"(case.toml:3:13: hardening of a material that does not yield
  expected yield_curvature with it)"},
      {"hardening_of_one",
       cloth("bending_stiffness = 1e-4\nyield_curvature = 100\nhardening = 1\n"),
       R"(case.toml:4:13: "hardening" is 1
  expected a number >= 0 and < 1)"},
      {"seam_of_nobody",
       sewn("body = \"shet\"\nedge = \"last_col\"\nto = \"other\"\nto_edge = \"first_col\"\n"),
       R"(case.toml:11:8: no body "shet"
  did you mean "sheet"?)"},
      {"seam_to_nobody",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nto = \"othr\"\nto_edge = \"first_col\"\n"),
       R"(case.toml:13:6: no body "othr"
  did you mean "other"?)"},
      {"seam_of_an_unknown_edge",
       sewn("body = \"sheet\"\nedge = \"last_column\"\nto = \"other\"\nto_edge = \"first_col\"\n"),
       R"(case.toml:12:8: "edge" is "last_column"
  did you mean "last_col"?)"},
      {"seam_without_an_edge", sewn("body = \"sheet\"\nto = \"other\"\nto_edge = \"first_col\"\n"),
       R"(case.toml:10:1: [[seam]] has no "edge"
  expected "edge", one of "first_row", "last_row", "first_col", "last_col")"},
      {"seam_beyond_the_edge",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nrange = [0, 5]\nto = \"other\"\nto_edge = "
            "\"first_col\"\n"),
       R"(case.toml:13:13: no vertex 5
  expected -5 to 4)"},
      {"seam_of_an_empty_range",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nto = \"other\"\nto_edge = "
            "\"first_col\"\nto_range = [3, 1]\n"),
       R"(case.toml:15:12: an empty range of to_range
  expected [first, last], first <= last)"},
      {"seam_of_an_edge_to_itself",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nto = \"sheet\"\nto_edge = \"last_col\"\n"),
       R"(case.toml:14:11: an edge that is sewn to itself
  expected another edge, or a range and a to_range of it)"},
      {"seam_that_never_closes",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nto = \"other\"\nto_edge = "
            "\"first_col\"\nclosing_time = 2\n"),
       R"(case.toml:15:16: closing_time is 2 s, longer than the run
  expected at most the duration, 1 s)"},
      {"hinged_seam_with_an_angle",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nto = \"other\"\nto_edge = "
            "\"first_col\"\nbending = \"hinged\"\nangle_deg = 10\n"),
       R"(case.toml:16:1: "angle_deg" does not belong to bending = "hinged"
  expected only with bending = "continuous")"},
      {"seam_of_a_shell",
       R"([material.shell]
model = "shell"
youngs_modulus = 1e9
shell_thickness = 1e-3
volume_density = 1000
[[body]]
name = "a"
material = "shell"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
[[seam]]
body = "a"
edge = "first_col"
to = "a"
to_edge = "last_col"
)",
       R"(case.toml:11:8: a seam of body "a", which is a shell
  expected model = "cloth" in [material.shell], or a [[tie]])"},
      {"seam_of_membranes_without_stiffness",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nto = \"other\"\nto_edge = \"first_col\"\n"),
       R"(case.toml:10:1: a seam of two membranes without stiffness, which give it none
  expected stiffness (N/m^2), or membrane_stiffness > 0 of a side)",
       {"material.cloth.membrane_stiffness=0"}},
      {"arc_length_with_a_closing_seam",
       "[static]\nloading = \"arc_length\"\nscale_gravity = true\n[time]\nmethod = \"static\"\n" +
           sewn("body = \"sheet\"\nedge = \"last_col\"\nto = \"other\"\nto_edge = "
                "\"first_col\"\nclosing_time = 0.5\n"),
       R"(case.toml:20:16: the seam closes in time, which static.loading = "arc_length" does not follow
  expected edges that meet at the start, static.loading = "in_time", or a method that follows the motion in time)"},
      {"channel_of_no_crease", "[output]\nchannels = [\"crease_curvature\"]\n" + sheet,
       R"(case.toml:2:13: the channel "crease_curvature" would be zero: no body yields
  expected a material with yield_curvature, or no "crease_curvature")"},
  };
}

// Cases that are refused once their shapes are known.
std::vector<BadCase> bad_seams() {
  return {
      {"edges_apart",
       sewn("body = \"sheet\"\nedge = \"first_col\"\nto = \"other\"\nto_edge = \"last_col\"\n"),
       R"(case.toml:10:1: the edges of the seam start up to 2 m apart
  expected edges that meet, or a closing_time in which they are drawn together)"},
      {"closed_edge",
       R"([material.cloth]
[[body]]
name = "tube"
shape = { type = "cylinder", radius = 0.1, length = 1, resolution = [5, 9] }
[[seam]]
body = "tube"
edge = "first_col"
to = "tube"
to_edge = "last_row"
)",
       R"(case.toml:5:1: body "tube" is closed along its columns: it has no such edge
  expected an edge where its surface ends)"},
      {"closed_to_open",
       R"([material.cloth]
[[body]]
name = "tube"
shape = { type = "cylinder", radius = 0.1, length = 1, resolution = [5, 9] }
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
[[seam]]
body = "tube"
edge = "first_row"
to = "sheet"
to_edge = "last_row"
)",
       R"(case.toml:8:1: an edge that is closed sewn to one that is open
  expected two closed edges, or a range of the closed one)"},
      {"single_vertex",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nrange = [2, 2]\nto = \"other\"\nto_edge = "
            "\"first_col\"\n"),
       R"(case.toml:10:1: a range of a single vertex
  expected two vertices at least)"},
      {"missing_patch",
       sewn("body = \"sheet\"\nedge = \"last_col\"\npatch = 1\nto = \"other\"\nto_edge = "
            "\"first_col\"\n"),
       R"(case.toml:10:1: body "sheet" has no patch 1
  expected 0..0)"},
      {"joined_patches",
       R"([material.cloth]
[[body]]
name = "ball"
shape = { type = "sphere", radius = 0.1, resolution = [5] }
[[body]]
name = "sheet"
shape = { type = "rectangle", size = [1, 1], resolution = [5, 9] }
[[seam]]
body = "ball"
edge = "first_col"
to = "sheet"
to_edge = "last_col"
closing_time = 0.5
)",
       R"(case.toml:8:1: an edge of body "ball" at which its surface does not end
  expected a border: there the patches of the shape are joined already)"},
      {"edge_onto_itself",
       sewn("body = \"sheet\"\nedge = \"last_col\"\nrange = [0, 2]\nto = \"sheet\"\nto_edge = "
            "\"last_col\"\nto_range = [0, 2]\n"),
       R"(case.toml:10:1: the seam sews an edge to itself
  expected two edges, or two parts of one)"},
  };
}

}  // namespace

class BadCloth : public testing::TestWithParam<BadCase> {};
TEST_P(BadCloth, IsRefused) { expect_refused(GetParam()); }
INSTANTIATE_TEST_SUITE_P(All, BadCloth, testing::ValuesIn(bad_cloth()), bad_case_name);

class BadSeam : public testing::TestWithParam<BadCase> {};
TEST_P(BadSeam, IsRefused) {
  try {
    build_scene(parse_case(GetParam().text, "case.toml", {}));
    FAIL() << "accepted:\n" << GetParam().text;
  } catch (const CaseError& error) {
    EXPECT_EQ(error.what(), GetParam().what);
  }
}
INSTANTIATE_TEST_SUITE_P(All, BadSeam, testing::ValuesIn(bad_seams()), bad_case_name);

}  // namespace weft::sim::bad_cloth_test
