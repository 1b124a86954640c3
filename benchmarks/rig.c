/* The rig in plain C: the limit that `rodless bench` measures the compiled package against.
 *
 * The same equations, the same ROS3 method with the same choice of steps and the same located
 * events as rodless_sim/physics, and the same PID, written out for the states of one rig: the
 * reconciled valve, a free carriage, both forms of friction. A test holds its runs to those of the
 * package. SI units throughout; the names are those of the package.
 */

#include <math.h>
#include <stdbool.h>

#define MIN(a, b) ((a) < (b) ? (a) : (b))
#define MAX(a, b) ((a) > (b) ? (a) : (b))

/* ---- constants, filled in by rodless_lab/benchmark/c_file.py ---- */

typedef struct {
    double static_force, coulomb, stribeck_velocity, viscous;
} Direction;

typedef struct {
    double gas_constant, isentropic_index, critical_ratio, viscosity, temperature, choked_function;
    double closed_voltage, curve_centre, area_coefficients[9], flow_coefficients[6];
    double spool_diameter, gap_length, gap_height, gap_fade_voltage;
    double piston_area, stroke, moving_mass, dead_volume_a, dead_volume_b;
    double saturating, high_speed_viscous, saturation_velocity;
    Direction forward, reverse;
    double capture_velocity, restitution, supply_pressure, ambient_pressure;
} Plant;

typedef struct {
    double kp, ki, kd, filter_bandwidth, feedforward, integral_zone, error_dead_band;
    double conditional_integration, back_calculation, tracking_time;
    double dead_zone_voltage, dead_zone_width, neutral_voltage, minimum_voltage, maximum_voltage;
} Gains;

/* ---- state ---- */

typedef struct {
    double position, velocity, pressure_a, pressure_b;
} Motion;

static inline Motion moved(Motion s, Motion rate, double duration) {
    return (Motion){s.position + duration * rate.position, s.velocity + duration * rate.velocity,
                    s.pressure_a + duration * rate.pressure_a,
                    s.pressure_b + duration * rate.pressure_b};
}

static inline Motion stopped(Motion s) {
    s.velocity = 0.0;
    return s;
}

/* ---- valve: openings and flows, eqs. (1)-(25) ---- */

#define SPOOL_GAIN 0.00021485
#define COEFFICIENT_RANGE 5.0
#define LAMINAR_RATIO 0.999

typedef struct {
    double orifice_area, gap;
} Edge;

typedef struct {
    bool forward;
    Edge opening, closing;
} Lands;

typedef struct {
    double mass_flow, by_pressure_1, by_pressure_2;
} Flow;

typedef struct {
    double mass_flow, by_pressure;
} Inflow;

typedef struct {
    Inflow a, b;
} Inflows;

static inline double effective_area(const Plant *p, double voltage) {
    const double *c = p->area_coefficients;
    return 1e-6 * (c[0] * sin(c[1] * voltage + c[2]) + c[3] * sin(c[4] * voltage + c[5]) +
                   c[6] * sin(c[7] * voltage + c[8]));
}

static inline double flow_coefficient(const Plant *p, double deflection) {
    const double c = MIN(fabs(deflection), COEFFICIENT_RANGE), *k = p->flow_coefficients;
    return k[0] + c * (k[1] + c * (k[2] + c * (k[3] + c * (k[4] + c * k[5]))));
}

static inline double gap_conductance(const Plant *p, double length) {
    const double height = p->gap_height;
    return M_PI * p->spool_diameter * (height * (height * height)) /
           (24.0 * p->viscosity * length * p->gas_constant * p->temperature);
}

static inline Lands openings(const Plant *p, double voltage) {
    const double deflection = voltage - p->closed_voltage;
    const double beyond_closed = effective_area(p, p->curve_centre + deflection) -
                                 effective_area(p, p->curve_centre);
    const double area = flow_coefficient(p, deflection) * MAX(beyond_closed, 0.0);
    const double ratio = deflection / p->gap_fade_voltage;
    const double fade = exp(-(ratio * ratio));
    const double overlap = p->gap_length + fabs(SPOOL_GAIN * deflection);
    return (Lands){deflection >= 0.0,
                   {area, fade * gap_conductance(p, p->gap_length)},
                   {0.0, gap_conductance(p, overlap)}};
}

static inline Flow orifice(const Plant *p, double area, double pressure_1, double pressure_2) {
    if (area == 0.0)
        return (Flow){0.0, 0.0, 0.0};
    const double index = p->isentropic_index;
    const double upstream = MAX(pressure_1, pressure_2);
    const double ratio = MIN(pressure_1, pressure_2) / upstream;
    const double conductance = area / sqrt(p->gas_constant * p->temperature);
    double function = p->choked_function, slope = 0.0;
    if (!(ratio < p->critical_ratio)) {
        const double r = MIN(ratio, LAMINAR_RATIO);
        const double q = pow(r, 1.0 / index);
        function = sqrt(2.0 * index / (index - 1.0) * (q * q - r * q));
        if (ratio > LAMINAR_RATIO) {
            slope = -function / (1.0 - LAMINAR_RATIO);
            function = slope * (ratio - 1.0);
        } else {
            slope = (2.0 * q * q / ratio - (index + 1.0) * q) / ((index - 1.0) * function);
        }
    }
    const double flow = conductance * upstream * function;
    const double by_upstream = conductance * (function - ratio * slope);
    const double by_downstream = conductance * slope;
    if (pressure_1 >= pressure_2)
        return (Flow){flow, by_upstream, by_downstream};
    return (Flow){-flow, -by_downstream, -by_upstream};
}

static inline Flow flow_past(const Plant *p, Edge edge, double pressure_1, double pressure_2) {
    const Flow f = orifice(p, edge.orifice_area, pressure_1, pressure_2);
    return (Flow){f.mass_flow + edge.gap * (pressure_1 * pressure_1 - pressure_2 * pressure_2),
                  f.by_pressure_1 + 2.0 * edge.gap * pressure_1,
                  f.by_pressure_2 + -2.0 * edge.gap * pressure_2};
}

static inline Inflow net_inflow(const Plant *p, Edge inlet, Edge outlet, double pressure) {
    const Flow inward = flow_past(p, inlet, p->supply_pressure, pressure);
    const Flow outward = flow_past(p, outlet, pressure, p->ambient_pressure);
    return (Inflow){inward.mass_flow - outward.mass_flow,
                    inward.by_pressure_2 - outward.by_pressure_1};
}

static inline Inflows inflows(const Plant *p, const Lands *lands, Motion s) {
    const Edge first = lands->forward ? lands->opening : lands->closing;
    const Edge second = lands->forward ? lands->closing : lands->opening;
    return (Inflows){net_inflow(p, first, second, s.pressure_a),
                     net_inflow(p, second, first, s.pressure_b)};
}

/* ---- friction, eqs. (28)-(29) ---- */

typedef struct {
    double force, by_speed;
} Drag;

static inline const Direction *side_of(const Plant *p, int direction) {
    return direction > 0 ? &p->forward : &p->reverse;
}

static inline Drag sliding(const Plant *p, double velocity, int direction) {
    const Direction *side = side_of(p, direction);
    const double speed = velocity * direction, ahead = MAX(speed, 0.0);
    const double ratio = ahead / side->stribeck_velocity;
    const double drop = (side->static_force - side->coulomb) * exp(-(ratio * ratio));
    double force = side->coulomb + drop;
    double by_speed = -2.0 * ratio / side->stribeck_velocity * drop;
    if (p->saturating != 0.0) {
        const double knee = p->saturation_velocity, high = p->high_speed_viscous;
        const double fading = exp(-ahead / knee);
        force += high * ahead + (side->viscous - high) * (knee * (1.0 - fading));
        by_speed += high + (side->viscous - high) * fading;
    } else {
        force += side->viscous * ahead;
        by_speed += side->viscous;
    }
    return (Drag){direction * (force + by_speed * MIN(speed, 0.0)), by_speed};
}

/* ---- equations of motion, eqs. (26), (27), (28), (31) ---- */

typedef struct {
    double rate, by_position, by_velocity, by_pressure;
} PressureRate;

typedef struct {
    double velocity, acceleration, by_velocity, by_pressure;
    PressureRate a, b;
} Rates;

static inline double volume_a(const Plant *p, double position) {
    return p->dead_volume_a + p->piston_area * position;
}

static inline double volume_b(const Plant *p, double position) {
    return p->dead_volume_b + p->piston_area * (p->stroke - position);
}

static inline PressureRate chamber_rate(const Plant *p, double volume, double area, double velocity,
                                        double pressure, Inflow flow) {
    const double stiffness = p->isentropic_index / volume;
    const double heat = p->gas_constant * p->temperature;
    const double rate = stiffness * (heat * flow.mass_flow - pressure * (area * velocity));
    return (PressureRate){rate, -area / volume * rate, -stiffness * pressure * area,
                          stiffness * (heat * flow.by_pressure - area * velocity)};
}

static inline PressureRate rate_a(const Plant *p, Motion s, const Inflows *flows, double velocity) {
    return chamber_rate(p, volume_a(p, s.position), p->piston_area, velocity, s.pressure_a,
                        flows->a);
}

static inline PressureRate rate_b(const Plant *p, Motion s, const Inflows *flows, double velocity) {
    return chamber_rate(p, volume_b(p, s.position), -p->piston_area, velocity, s.pressure_b,
                        flows->b);
}

static inline double net_force(const Plant *p, Motion s) {
    return p->piston_area * (s.pressure_a - s.pressure_b);
}

static inline double lowest_force(const Plant *p, double position) {
    return position <= 0.0 ? -INFINITY : -p->reverse.static_force;
}

static inline double highest_force(const Plant *p, double position) {
    return position >= p->stroke ? INFINITY : p->forward.static_force;
}

static inline int sliding_direction(const Plant *p, Motion s) {
    const double speed = fabs(s.velocity), force = net_force(p, s);
    if (speed <= p->capture_velocity) {
        const double high = highest_force(p, s.position);
        if (lowest_force(p, s.position) <= force && force <= high)
            return 0;
        if (speed == 0.0)
            return force > high ? 1 : -1;
    }
    return s.velocity > 0.0 ? 1 : -1;
}

static inline Rates sliding_rates(const Plant *p, Motion s, const Inflows *flows, int direction) {
    const double mass = p->moving_mass;
    const Drag drag = sliding(p, s.velocity, direction);
    return (Rates){s.velocity,
                   (net_force(p, s) - drag.force) / mass,
                   -drag.by_speed / mass,
                   p->piston_area / mass,
                   rate_a(p, s, flows, s.velocity),
                   rate_b(p, s, flows, s.velocity)};
}

static inline Motion rates(const Plant *p, const Lands *lands, Motion s, int direction) {
    const Inflows flows = inflows(p, lands, s);
    const Rates found = sliding_rates(p, s, &flows, direction);
    return (Motion){found.velocity, found.acceleration, found.a.rate, found.b.rate};
}

/* ---- one step: ROS3, Sandu et al., Atmospheric Environment 31, 1997 ---- */

#define GAMMA 0.43586652150845899942
#define C21 (-1.0156171083877702)
#define C31 4.0759956452537700
#define C32 9.2076794298330791
#define B2 6.1697947043828246
#define B3 (-0.42772256543218573)
#define E1 0.5
#define E2 (-2.9079558716805470)
#define E3 0.22354069897811570

#define POSITION_ERROR 1e-8
#define VELOCITY_ERROR 1e-5
#define PRESSURE_ERROR 2.0

typedef struct {
    Motion after;
    double error;
} Step;

typedef struct {
    double inverse, by_position, by_velocity;
} Leaf;

typedef struct {
    double inverse, by_pressure, pivot;
    Leaf a, b;
} Matrix;

static inline Leaf leaf(PressureRate rate, double diagonal) {
    const double inverse = 1.0 / (diagonal - rate.by_pressure);
    return (Leaf){inverse, rate.by_position,
                  (rate.by_position / diagonal + rate.by_velocity) * inverse};
}

static inline Matrix eliminated(const Rates *first, double step) {
    const double diagonal = 1.0 / (GAMMA * step);
    const Leaf a = leaf(first->a, diagonal), b = leaf(first->b, diagonal);
    const double own = diagonal - first->by_velocity;
    const double pivot = 1.0 / (own - first->by_pressure * (a.by_velocity - b.by_velocity));
    return (Matrix){1.0 / diagonal, first->by_pressure, pivot, a, b};
}

static inline Motion solved(const Matrix *m, Motion right) {
    const double shift = right.position * m->inverse;
    const double rest_a = (right.pressure_a + m->a.by_position * shift) * m->a.inverse;
    const double rest_b = (right.pressure_b + m->b.by_position * shift) * m->b.inverse;
    const double velocity = (right.velocity + m->by_pressure * (rest_a - rest_b)) * m->pivot;
    return (Motion){shift + velocity * m->inverse, velocity, rest_a + m->a.by_velocity * velocity,
                    rest_b + m->b.by_velocity * velocity};
}

static inline Step sliding_step(const Plant *p, const Lands *lands, Motion s, int direction,
                                const Rates *first, double step) {
    const Matrix m = eliminated(first, step);
    const Motion u1 = solved(
        &m, (Motion){first->velocity, first->acceleration, first->a.rate, first->b.rate});
    const Motion later = rates(p, lands, moved(s, u1, 1.0), direction);
    const Motion u2 = solved(&m, moved(later, u1, C21 / step));
    const Motion u3 = solved(&m, moved(moved(later, u1, C31 / step), u2, C32 / step));
    const Motion after = moved(moved(moved(s, u1, 1.0), u2, B2), u3, B3);
    const Motion none = {0.0, 0.0, 0.0, 0.0};
    const Motion e = moved(moved(moved(none, u1, E1), u2, E2), u3, E3);
    const double carriage =
        MAX(fabs(e.position) / POSITION_ERROR, fabs(e.velocity) / VELOCITY_ERROR);
    const double air = MAX(fabs(e.pressure_a), fabs(e.pressure_b)) / PRESSURE_ERROR;
    const double total = e.position + e.velocity + e.pressure_a + e.pressure_b;
    return (Step){after, MAX(carriage, air) + 0.0 * total};
}

static inline Step sticking_step(const Plant *p, const Lands *lands, Motion s, PressureRate a,
                                 PressureRate b, double step) {
    const double diagonal = 1.0 / (GAMMA * step);
    const double inverse_a = 1.0 / (diagonal - a.by_pressure);
    const double inverse_b = 1.0 / (diagonal - b.by_pressure);
    const double a1 = a.rate * inverse_a, b1 = b.rate * inverse_b;
    const Motion halfway = {s.position, 0.0, s.pressure_a + a1, s.pressure_b + b1};
    const Inflows flows = inflows(p, lands, halfway);
    const double later_a = rate_a(p, halfway, &flows, 0.0).rate;
    const double later_b = rate_b(p, halfway, &flows, 0.0).rate;
    const double a2 = (later_a + C21 / step * a1) * inverse_a;
    const double b2 = (later_b + C21 / step * b1) * inverse_b;
    const double a3 = (later_a + C31 / step * a1 + C32 / step * a2) * inverse_a;
    const double b3 = (later_b + C31 / step * b1 + C32 / step * b2) * inverse_b;
    const double error_a = E1 * a1 + E2 * a2 + E3 * a3, error_b = E1 * b1 + E2 * b2 + E3 * b3;
    return (Step){{s.position, 0.0, s.pressure_a + a1 + B2 * a2 + B3 * a3,
                   s.pressure_b + b1 + B2 * b2 + B3 * b3},
                  MAX(fabs(error_a), fabs(error_b)) / PRESSURE_ERROR};
}

static inline double next_step(double step, double error) {
    if (error < 0.005)
        return 5.0 * step;
    if (!(error < 600.0))
        return 0.1 * step;
    return 0.85 * step * pow(error, -1.0 / 3.0);
}

/* ---- events: where within a step the carriage stops, breaks away or strikes a cap ---- */

#define SMALLEST_FORCE 1e-8
#define SMALLEST_VELOCITY 1e-12
#define SMALLEST_GAP 1e-13
#define SLOWEST_REBOUND 3e-5
#define MOST_TRIALS 60
#define MOST_HALVINGS 40
#define SHORTEST 1e-12
#define PARTS 8

typedef struct {
    Motion state;
    int direction;
    double elapsed;
} Event;

typedef struct {
    double before, value_before, after, value_after;
} Bracket;

static double guess(Bracket b) {
    const double rise = b.value_after - b.value_before;
    if (rise == 0.0)
        return b.after;
    const double found = b.after - b.value_after * (b.after - b.before) / rise;
    return MAX(found, SHORTEST * MAX(b.before, b.after));
}

static Bracket narrowed(Bracket b, double time, double value) {
    if ((value > 0.0) == (b.value_after > 0.0))
        return (Bracket){b.before, 0.5 * b.value_before, time, value};
    return (Bracket){b.after, b.value_after, time, value};
}

static double gap_ahead(const Plant *p, Motion s, int direction) {
    return direction > 0 ? p->stroke - s.position : s.position;
}

static inline bool stops_within(double speed, double rate, double after, double rate_after,
                                double step) {
    if (after <= 0.0)
        return true;
    if (speed == 0.0)
        return false;
    const double first = step * rate;
    const double second = 3.0 * (after - speed) - step * (2.0 * rate + rate_after);
    const double third = 2.0 * (speed - after) + step * (rate + rate_after);
    const double discriminant = second * second - 3.0 * first * third;
    if (discriminant <= 0.0)
        return false;
    const double curvature = second + sqrt(discriminant);
    if (curvature == 0.0)
        return false;
    const double place = -first / curvature;
    const double lowest = speed + place * (first + place * (second + place * third));
    return 0.0 < place && place < 1.0 && lowest < 0.0;
}

static Event standstill(const Plant *p, const Lands *lands, Motion s, int direction,
                        const Rates *first, double step, Motion after) {
    Bracket bracket = {0.0, direction * s.velocity, step, direction * after.velocity};
    if (bracket.value_after > 0.0) {
        for (int part = 1; part < PARTS && bracket.value_after > 0.0; part++) {
            const double time = step * part / PARTS;
            const Motion found = sliding_step(p, lands, s, direction, first, time).after;
            if (direction * found.velocity <= 0.0)
                bracket.after = time, bracket.value_after = direction * found.velocity;
        }
        if (bracket.value_after > 0.0)
            return (Event){after, direction, -1.0};
    }
    if (bracket.value_before <= 0.0) {
        double time = bracket.after;
        for (int k = 0; k < MOST_HALVINGS; k++) {
            time *= 0.5;
            const Motion found = sliding_step(p, lands, s, direction, first, time).after;
            if (direction * found.velocity > 0.0) {
                bracket.before = time, bracket.value_before = direction * found.velocity;
                break;
            }
            bracket.after = time, bracket.value_after = direction * found.velocity;
        }
        if (bracket.value_before <= 0.0)
            return (Event){stopped(s), 0, 0.0};
    }
    Motion found = after;
    for (int k = 0; k < MOST_TRIALS; k++) {
        const double time = guess(bracket);
        found = sliding_step(p, lands, s, direction, first, time).after;
        const double value = direction * found.velocity;
        bracket = narrowed(bracket, time, value);
        if (fabs(value) < SMALLEST_VELOCITY || bracket.before == bracket.after)
            break;
    }
    found = stopped(found);
    return (Event){found, sliding_direction(p, found), bracket.after};
}

static Event impact(const Plant *p, const Lands *lands, Motion s, int direction,
                    const Rates *first, Event until) {
    Bracket bracket = {0.0, gap_ahead(p, s, direction), until.elapsed,
                       gap_ahead(p, until.state, direction)};
    Motion found = s;
    double elapsed = 0.0;
    if (bracket.value_before > 0.0) {
        for (int k = 0; k < MOST_TRIALS; k++) {
            elapsed = guess(bracket);
            found = sliding_step(p, lands, s, direction, first, elapsed).after;
            const double gap = gap_ahead(p, found, direction);
            bracket = narrowed(bracket, elapsed, gap);
            if (fabs(gap) < SMALLEST_GAP || bracket.before == bracket.after)
                break;
        }
    }
    const double rebound = -p->restitution * found.velocity;
    found.position = direction > 0 ? p->stroke : 0.0;
    found.velocity = fabs(rebound) > SLOWEST_REBOUND ? rebound : 0.0;
    return (Event){found, sliding_direction(p, found), elapsed};
}

static __attribute__((noinline)) Event sliding_event(const Plant *p, const Lands *lands, Motion s,
                                                     int direction, const Rates *first,
                                                     double step, Motion after, bool stops) {
    Event event = {after, direction, step};
    if (stops) {
        const Event found = standstill(p, lands, s, direction, first, step, after);
        if (found.elapsed >= 0.0)
            event = found;
    }
    if (gap_ahead(p, event.state, direction) <= 0.0 && event.elapsed > 0.0)
        event = impact(p, lands, s, direction, first, event);
    return event;
}

static __attribute__((noinline)) Event breakaway(const Plant *p, const Lands *lands, Motion s,
                                                 PressureRate a, PressureRate b, double step,
                                                 Motion after) {
    const double low = lowest_force(p, s.position), high = highest_force(p, s.position);
    const int direction = net_force(p, after) > high ? 1 : -1;
    const double limit = direction > 0 ? high : -low;
    Bracket bracket = {0.0, direction * net_force(p, s) - limit, step,
                       direction * net_force(p, after) - limit};
    Motion found = after;
    if (bracket.value_before >= 0.0) {
        for (int k = 0; k < MOST_HALVINGS / 2; k++) {
            const double time = 0.5 * bracket.after;
            found = sticking_step(p, lands, s, a, b, time).after;
            const double value = direction * net_force(p, found) - limit;
            if (value < 0.0) {
                bracket.before = time, bracket.value_before = value;
                break;
            }
            bracket.after = time, bracket.value_after = value;
        }
        if (bracket.value_before >= 0.0)
            return (Event){found, direction, bracket.after};
    }
    for (int k = 0; k < MOST_TRIALS; k++) {
        const double time = guess(bracket);
        found = sticking_step(p, lands, s, a, b, time).after;
        const double value = direction * net_force(p, found) - limit;
        bracket = narrowed(bracket, time, value);
        if (fabs(value) < SMALLEST_FORCE || bracket.before == bracket.after)
            break;
    }
    return (Event){found, direction, bracket.after};
}

/* ---- motion over one period ---- */

#define LONGEST_STEP 1e-3
#define MOST_STEPS 100000
#define MOST_STEPS_PER_SECOND 1e6
#define UNSTABLE_SHARE 0.25
#define FALL 2.5
#define FALL_SHARE 0.5
#define FALL_ACCURACY 10.0

enum { SOUND, NOT_FINITE, NO_PRESSURE, NO_VOLUME, TOO_MANY_STEPS };

typedef struct {
    Motion state;
    int direction;
    double elapsed, step;
} Attempt;

static inline bool may_fall(double speed, double stribeck_velocity) {
    return fabs(speed) < 3.0 * stribeck_velocity;
}

static inline double step_in_the_fall(double speed, double after, double slope,
                                      double stribeck_velocity, double step) {
    if (may_fall(after, stribeck_velocity) && slope * step > UNSTABLE_SHARE)
        return 0.8 * UNSTABLE_SHARE / slope;
    const double change = fabs(after - speed), edge = FALL * stribeck_velocity;
    if (change > FALL_SHARE * stribeck_velocity && MIN(speed, after) < edge) {
        const double ahead = speed > edge ? speed - 0.96 * edge : 0.0;
        return step * MIN(0.9, MAX(ahead, 0.8 * FALL_SHARE * stribeck_velocity) / change);
    }
    return step;
}

static inline bool cruises(double speed, double rate, double after, double stribeck_velocity,
                           double step) {
    const double slowest = MIN(speed, after);
    return slowest > 3.0 * stribeck_velocity && fabs(rate * step) < slowest;
}

static inline Attempt sliding_attempt(const Plant *p, const Lands *lands, Motion s,
                                      const Inflows *flows, int direction, double step,
                                      double tolerance) {
    const Rates first = sliding_rates(p, s, flows, direction);
    const double stribeck_velocity = side_of(p, direction)->stribeck_velocity;
    if (first.by_velocity * step > UNSTABLE_SHARE && may_fall(s.velocity, stribeck_velocity))
        step = UNSTABLE_SHARE / first.by_velocity;
    const Step taken = sliding_step(p, lands, s, direction, &first, step);
    double error = taken.error / tolerance;
    const double speed = direction * s.velocity, speed_after = direction * taken.after.velocity;
    if (may_fall(MIN(speed, speed_after), stribeck_velocity))
        error *= FALL_ACCURACY;
    if (!(error <= 1.0))
        return (Attempt){s, direction, 0.0, next_step(step, error)};
    const double rate = direction * first.acceleration;
    bool stops = false;
    if (!cruises(speed, rate, speed_after, stribeck_velocity, step)) {
        const Drag drag = sliding(p, taken.after.velocity, direction);
        const double mass = p->moving_mass, slope = -drag.by_speed / mass;
        const double shorter = step_in_the_fall(speed, speed_after, slope, stribeck_velocity, step);
        if (shorter < step)
            return (Attempt){s, direction, 0.0, shorter};
        const double rate_after = direction * (net_force(p, taken.after) - drag.force) / mass;
        stops = stops_within(speed, rate, speed_after, rate_after, step);
    }
    if (stops || gap_ahead(p, taken.after, direction) <= 0.0) {
        const Event event =
            sliding_event(p, lands, s, direction, &first, step, taken.after, stops);
        return (Attempt){event.state, event.direction, event.elapsed, LONGEST_STEP};
    }
    return (Attempt){taken.after, direction, step, next_step(step, error)};
}

static inline Attempt sticking_attempt(const Plant *p, const Lands *lands, Motion s,
                                       const Inflows *flows, double step, double tolerance) {
    const PressureRate a = rate_a(p, s, flows, 0.0), b = rate_b(p, s, flows, 0.0);
    const Step taken = sticking_step(p, lands, s, a, b, step);
    const double error = taken.error / tolerance;
    if (!(error <= 1.0))
        return (Attempt){s, 0, 0.0, next_step(step, error)};
    const double force = net_force(p, taken.after);
    if (lowest_force(p, s.position) <= force && force <= highest_force(p, s.position))
        return (Attempt){taken.after, 0, step, next_step(step, error)};
    const Event event = breakaway(p, lands, s, a, b, step, taken.after);
    return (Attempt){event.state, event.direction, event.elapsed, LONGEST_STEP};
}

static inline int fault_of(const Plant *p, Motion s) {
    if (!isfinite(s.position + s.velocity + s.pressure_a + s.pressure_b))
        return NOT_FINITE;
    if (s.pressure_a <= 0.0 || s.pressure_b <= 0.0)
        return NO_PRESSURE;
    if (MIN(volume_a(p, s.position), volume_b(p, s.position)) <= 0.0)
        return NO_VOLUME;
    return SOUND;
}

static inline int advance_from(const Plant *p, const Lands *lands, Motion *state, Inflows flows,
                               double period, double tolerance) {
    double left = period, step = period;
    int direction = sliding_direction(p, *state);
    const long most = MOST_STEPS + (long)(MOST_STEPS_PER_SECOND * period);
    for (long k = 0; k < most; k++) {
        step = MIN(step, LONGEST_STEP);
        if (step >= left)
            step = left;
        else if (step > 0.5 * left)
            step = 0.5 * left;
        const Attempt attempt =
            direction == 0
                ? sticking_attempt(p, lands, stopped(*state), &flows, step, tolerance)
                : sliding_attempt(p, lands, *state, &flows, direction, step, tolerance);
        *state = attempt.state;
        direction = attempt.direction;
        step = attempt.step;
        left -= attempt.elapsed;
        if (left <= 0.0)
            return fault_of(p, *state);
        if (attempt.elapsed > 0.0)
            flows = inflows(p, lands, *state);
    }
    return TOO_MANY_STEPS;
}

/* ---- PID, as rodless_control/laws/pid.py ---- */

typedef struct {
    double integral, filtered_position, filtered_velocity, offset, error, reference_velocity;
} Memory;

typedef struct {
    double voltage, error, p, i, d, feedforward;
} Command;

static inline double compensated(const Gains *g, double effort) {
    return g->neutral_voltage + effort +
           g->dead_zone_voltage * tanh(effort / g->dead_zone_width);
}

static inline double limited(const Gains *g, double voltage) {
    return MIN(MAX(voltage, g->minimum_voltage), g->maximum_voltage);
}

static inline double integrated(const Gains *g, double integral, double others, double error,
                                double interval) {
    if (!(fabs(error) > g->error_dead_band))
        return integral;
    if (!(fabs(error) < g->integral_zone)) {
        const double change = g->ki * copysign(g->integral_zone, error) * interval;
        if (integral * change >= 0.0)
            return integral;
        const double moved = integral + change;
        return moved * integral > 0.0 ? moved : 0.0;
    }
    const double grown = integral + g->ki * error * interval;
    const double wanted = compensated(g, others + grown), excess = wanted - limited(g, wanted);
    if (g->conditional_integration != 0.0 && excess * (grown - integral) > 0.0)
        return integral;
    if (g->back_calculation != 0.0)
        return grown - excess * MIN(interval / g->tracking_time, 1.0);
    return grown;
}

static inline Command update(const Gains *g, Memory *m, double position, const double *reference,
                             double interval) {
    if (interval > 0.0) {
        const double share = 1.0 - exp(-g->filter_bandwidth * interval);
        const double change = share * (position - m->filtered_position);
        m->filtered_position += change;
        m->filtered_velocity = change / interval;
    }
    m->error = reference[0] - position;
    m->reference_velocity = reference[1];
    const double p = g->kp * m->error, d = -g->kd * m->filtered_velocity;
    const double feedforward = g->feedforward * reference[1];
    m->offset *= exp(-interval / g->tracking_time);
    m->integral =
        integrated(g, m->integral, p + d + feedforward + m->offset, m->error, interval);
    const double voltage =
        limited(g, compensated(g, p + m->integral + m->offset + d + feedforward));
    return (Command){voltage, m->error, p, m->integral + m->offset, d, feedforward};
}

/* ---- what Python calls ---- */

typedef struct {
    Motion state;
    double mass_flow_a, mass_flow_b;
} Row;

/* Follow references (n pairs of m and m/s), one row and one command per sample; return the fault. */
int closed_loop(const Plant *p, const Gains *g, const double *references, long n, Motion state,
                double period, double tolerance, Row *rows, Command *commands) {
    Memory memory = {0.0, state.position, 0.0, 0.0, 0.0, 0.0};
    for (long k = 0; k < n; k++) {
        commands[k] =
            update(g, &memory, state.position, references + 2 * k, k == 0 ? 0.0 : period);
        const Lands lands = openings(p, commands[k].voltage);
        const Inflows flows = inflows(p, &lands, state);
        rows[k] = (Row){state, flows.a.mass_flow, flows.b.mass_flow};
        if (k + 1 < n) {
            const int fault = advance_from(p, &lands, &state, flows, period, tolerance);
            if (fault != SOUND)
                return fault;
        }
    }
    return SOUND;
}

/* Apply n voltages, one after the other; n + 1 rows. */
int open_loop(const Plant *p, const double *voltages, long n, Motion state, double period,
              double tolerance, Row *rows) {
    for (long k = 0; k <= n; k++) {
        const Lands lands = openings(p, voltages[MIN(k, n - 1)]);
        const Inflows flows = inflows(p, &lands, state);
        rows[k] = (Row){state, flows.a.mass_flow, flows.b.mass_flow};
        if (k < n) {
            const int fault = advance_from(p, &lands, &state, flows, period, tolerance);
            if (fault != SOUND)
                return fault;
        }
    }
    return SOUND;
}
