// The outcomes of the crash model (design.md section 3): what one simulated design did.
#ifndef SOBOX_COMMON_SCENARIO_OUTCOME_H
#define SOBOX_COMMON_SCENARIO_OUTCOME_H

// Enumerator, name in scenarios and JSON, unit, meaning. Read at the end of the simulation unless
// the meaning says otherwise. After these, one `energy_absorbed.SPRING` [J] for each spring
// (what it took from the vehicle, its lateral work subtracted), then one `deformation_max.SPRING`
// [m] (the greatest it had in contact).
#define OUTCOME_LIST(X)                                                                          \
    X(OUTCOME_S_L, "s_L", "m", "length of the first spring when it was last in contact")         \
    X(OUTCOME_S_L_MIN, "s_L_min", "m", "least length of the first spring in contact")            \
    X(OUTCOME_ABWAP, "AbWAP", "1", "lateral travel of the A-pillar over the overlap")            \
    X(OUTCOME_ABWP, "AbWP", "1",                                                                 \
      "lateral travel of its projection on the barrier over the overlap")                        \
    X(OUTCOME_YAW_DEG, "yaw_deg", "deg", "yaw of the vehicle")                                   \
    X(OUTCOME_YAW_MAX_DEG, "yaw_max_deg", "deg", "greatest absolute yaw")                        \
    X(OUTCOME_TRAVEL_X, "travel_x", "m", "travel of the COG along the road, positive forwards")  \
    X(OUTCOME_TRAVEL_Y, "travel_y", "m", "lateral travel of the COG, away from the barrier")     \
    X(OUTCOME_DELTA_VX, "delta_vx", "m/s", "change of the COG's velocity in x")                  \
    X(OUTCOME_DELTA_VY, "delta_vy", "m/s", "change of the COG's velocity in y")                  \
    X(OUTCOME_DECEL_MAX_G, "decel_max_g", "g", "greatest absolute acceleration of the COG in x") \
    X(OUTCOME_DECEL_MEAN_G, "decel_mean_g", "g", "mean acceleration in x while in contact")      \
    X(OUTCOME_KINETIC_ENERGY, "kinetic_energy", "J", "kinetic energy left")                      \
    X(OUTCOME_LATERAL_WORK, "lateral_work", "J", "energy that the lateral forces gave the car")  \
    X(OUTCOME_ENERGY_BALANCE, "energy_balance", "J",                                             \
      "kinetic energy lost minus the energy that the springs absorbed")

enum outcome {
#define OUTCOME_ENUM(name, text, unit, meaning) name,
    OUTCOME_LIST(OUTCOME_ENUM)
#undef OUTCOME_ENUM
    // Of spring 0; spring i follows at OUTCOME_ENERGY_ABSORBED + i, and the greatest
    // deformations at OUTCOME_ENERGY_ABSORBED + spring_count + i.
    OUTCOME_ENERGY_ABSORBED,
};

#endif
