// A small valid scenario with every section, which the tests of this folder break in turn. Line
// numbers of expected messages count from its first line.
#ifndef SOBOX_TESTS_UNIT_COMMON_SCENARIO_EXAMPLE_H
#define SOBOX_TESTS_UNIT_COMMON_SCENARIO_EXAMPLE_H

static const char example[] = "name: example\n"                                       // 1
                              "model: small_overlap\n"                                // 2
                              "vehicle:\n"                                            // 3
                              "  mass: 1650\n"                                        // 4
                              "  yaw_inertia: 3000\n"                                 // 5
                              "  speed: 17.889\n"                                     // 6
                              "  cog: [0.1, 0.0]   # m\n"                             // 7
                              "barrier:\n"                                            // 8
                              "  face_x: -2.08\n"                                     // 9
                              "  edge_y: -0.455\n"                                    // 10
                              "  width: 1.2\n"                                        // 11
                              "  overlap: 0.455\n"                                    // 12
                              "  profile: rounded\n"                                  // 13
                              "  edge_radius: 0.2\n"                                  // 14
                              "springs:\n"                                            // 15
                              "  - name: front\n"                                     // 16
                              "    position: [-0.83, -0.75]\n"                        // 17
                              "    deformation: [0.0, 0.5, 1.0]\n"                    // 18
                              "    force_x: {lower: 0, upper: [60e3, 80e3, 450e3]}\n" // 19
                              "    force_y: {lower: [0, 1, 2], upper: 250e3}\n"       // 20
                              "  - name: rail-2\n"                                    // 21
                              "    position: [-1.0, -0.5]\n"                          // 22
                              "    length: 1.5\n"                                     // 23
                              "    deformation: [0.1, 0.9]\n"                         // 24
                              "    force_x: {lower: 7, upper: 7}\n"                   // 25
                              "    force_y: {lower: -1e3, upper: 1e3}\n"              // 26
                              "simulation:\n"                                         // 27
                              "  duration: 0.12\n"                                    // 28
                              "  time_step: 5.0e-4\n"                                 // 29
                              "  integrator: velocity_verlet\n"                       // 30
                              "response: glancing_off\n"                              // 31
                              "firewall_distance: 0.25\n"                             // 32
                              "constraints:\n"                                        // 33
                              "  yaw_deg: {min: -20, max: 10}\n"                      // 34
                              "  energy_absorbed.rail-2: {max: 9e4}\n"                // 35
                              "  s_L: {max: 1.0}\n"                                   // 36
                              "search:\n"                                             // 37
                              "  samples: 20e1\n"                                     // 38
                              "  exploration_steps: 10\n"                             // 39
                              "  consolidation_steps: 20\n"                           // 40
                              "  sampling: latin_hypercube\n"                         // 41
                              "  target_purity: 0.95\n"                               // 42
                              "  certificate_samples: 5000\n"                         // 43
                              "  seed: 9007199254740991\n";                           // 44

#endif
