# The public face of each room: the only headers that are installed. Each compiles alone, which tests/consumer checks.
# In each list, those after the line "included" are there because the others include them. Reasons and counts:
# docs/decisions/0037-public-headers.md.
set(weft_bsi_headers
  continuous_collision.h
  geometry_image.h
  level_of_detail.h
  narrow_phase.h
  proximity.h
  pyramid.h
  rigid_pyramid.h
  shapes.h
  sphere_hierarchy.h
  traversal.h
  triangle_intersection.h
  # included
  detail/block_levels.h
  detail/bound_rows.h
  detail/box_layout.h
  detail/exact_predicates.h
  leaf_pair.h
  sphere.h)
set(weft_materials_headers
  bending.h
  contact.h
  curved_bending.h
  drag.h
  fabric_membrane.h
  hinge.h
  measured_stretch.h
  membrane.h
  orthotropic_membrane.h
  spring.h
  stretch_curve.h
  # included
  jet.h
  lanes.h
  orthotropic_moduli.h
  strain_map.h
  types.h)
set(weft_gpu_headers
  colour_map.h
  renderer.h)
set(weft_sim_headers
  case/case.h
  case/case_error.h
  case/case_reader.h
  modes/buckling_modes.h
  modes/case_equilibrium.h
  modes/vibration_modes.h
  run/make_simulation.h
  run/recorded_run.h
  simulation/simulation.h
  trajectory/trajectory.h
  # included
  accuracy/accuracy_pilot.h
  accuracy/error_estimate.h
  base/bill.h
  base/failure.h
  base/file_error.h
  base/statistics.h
  base/step_census.h
  base/vectors.h
  case/varying.h)
