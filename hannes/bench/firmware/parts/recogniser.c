/* ---- what a program calls ---------------------------------------------------------------------- */

/* Rigid or soft, stiffness and grip force of a grasp, from one sample after the other. Every sum is
 * taken in the order in which Python takes it: with -ffp-contract=off and without -ffast-math the
 * features, the trees' votes and the calibrated probability have the same bits. */

enum { HANNES_SOFT, HANNES_RIGID, HANNES_UNKNOWN };

struct HannesDecision {
    uint8_t word;    /* HANNES_SOFT, HANNES_RIGID or HANNES_UNKNOWN */
    bool held;       /* an object is held now; only then is there a force */
    bool stiff;      /* an object was held so far; only then is there a stiffness */
    bool touched;    /* a contact was detected */
    double touch;    /* rad, where; before a contact, where the shaft is now */
    double window;   /* probability of rigid of this window alone */
    double rigid;    /* of the grasp so far, by which the word is said */
    double stiffness[3]; /* N/m: value, and the ends of its 95 % interval */
    double force[3];     /* N, the most so far: likewise */
    double pressed[3];   /* N/m: stiffness of an object that was pressed on in doubt, 0 before */
};

struct Hannes {
    uint32_t count;   /* samples since the grasp began */
    int32_t begun, touch;
    double first, running;
    double current[HANNES_KEPT], position[HANNES_KEPT], reference[HANNES_KEPT], level[HANNES_KEPT];
    double known[8], passed[HANNES_LEVELS];
    double odds;      /* fading mean of the log odds */
    uint32_t held;    /* windows in which an object was held */
    double log_stiffness[HANNES_HELD], apart[HANNES_HELD];
    double scratch[HANNES_SCRATCH];
    const double *hand; /* what an empty closure showed of it, NULL where it is not known */
    bool asked;       /* the traces were long enough */
    double pressed[3], bins[3][HANNES_BINS]; /* sums of current, position and reference */
    float row[HANNES_FEATURES];
};

#if HANNES_HAND
/* A closure on nothing, which shows the hand. */
struct HannesEmpty {
    uint32_t count;                /* samples since its command began */
    bool known;                    /* whole, and like those that were learned from */
    double current, lag;           /* sums of the mean that is under way */
    double means[HANNES_NUMBERS];  /* of current [A], then of lag [rad] */
    double point[HANNES_HAND];     /* what the networks see of them */
};
#endif

/* What the grip policy keeps from tick to tick. */
struct HannesGrip {
    bool firm, held, uncertain; /* uncertain: pressed on in doubt, so that the stiffness counts */
    bool released;            /* let go of, and not yet closing again */
    bool begun;               /* set_point is that of a tick */
    double lowest;            /* rad, since it was let go of */
    double since, certain;    /* s from the touch; s for which it was surely rigid */
    double mean;              /* probability of rigid, averaged */
    double share, offset, set_point; /* of the travel beyond the touch; rad from the touch; rad */
    double touch, rigid;      /* of what is held: rad, probability */
    double stiffness;         /* of the same, over the border of soft and rigid; 0: not known */
    double force, force_high; /* N, the last estimate */
};

/* The memory that the head of this file states is all there is. */
#if HANNES_HAND
#define HANNES_EMPTY_BYTES sizeof(struct HannesEmpty)
#else
#define HANNES_EMPTY_BYTES 0u
#endif
typedef char hannes_memory_as_stated[
    sizeof(struct Hannes) + sizeof(struct HannesGrip) + HANNES_EMPTY_BYTES <= HANNES_MEMORY_BYTES
        ? 1 : -1];

void hannes_reset(struct Hannes *h);
/* Takes one sample; true where a window ended with it, and `said` is new. */
bool hannes_sample(struct Hannes *h, double current, double position, double reference,
                   struct HannesDecision *said);
#if HANNES_HAND
void hannes_empty_reset(struct HannesEmpty *e);
/* Takes one sample of a closure on nothing, by the command of the experiment `empty-closure`, the
 * first where that begins; true once the hand is known. More samples change nothing. It needs the
 * sample of every period: where one was lost, call hannes_empty_reset() and close once more. */
bool hannes_empty(struct HannesEmpty *e, double current, double position, double reference);
/* That command [rad] at a time since its start [s]; it ends at HANNES_EMPTY_DURATION. */
double hannes_empty_command(double since);
#define HANNES_EMPTY_DURATION hannes_empty_times[HANNES_EMPTY_POINTS - 1u]
/* Call after each hannes_reset(): recognition then goes by the hand, if it is known. `e` must stay
 * as it is until the next hannes_reset(). */
void hannes_know(struct Hannes *h, const struct HannesEmpty *e);
#endif
void hannes_grip_reset(struct HannesGrip *g);
/* Ask at each sample, before hannes_sample(): true where a new grasp begins, as the hand turns to
 * close after a release; then call hannes_reset(). */
bool hannes_again(struct HannesGrip *g, double position);
/* Set point [rad] of the next tick, by what recognition says: `fresh` is what was just said, NULL
 * where nothing was; `wanted` the command [rad]; `force_wanted` a force set point [N], 0 for none. */
double hannes_grip(struct HannesGrip *g, const struct HannesDecision *fresh, double period,
                   double wanted, double position, double force_wanted);

/* ---- features ---------------------------------------------------------------------------------- */

enum { H_START, H_FREE, H_FREE_SPEED, H_PEAK, H_FARTHEST, H_WORK, H_STEEPEST, H_LAST };
enum { H_SINCE = 9, H_RISE = 10, H_TOUCH = 21 };

static double h_at(const double *values, int32_t sample)
{
    return values[(uint32_t)sample & (HANNES_KEPT - 1u)];
}

static double h_more(double a, double b)
{
    return b > a ? b : a;
}

/* Mean and least-squares slope (per s) of a window's samples before `end`. */
static double h_line(const double *values, int32_t end, double *slope)
{
    double middle = 0.5 * (HANNES_WINDOW - 1), total = 0.0, moment = 0.0, square = 0.0;
    for (int32_t k = 0; k < HANNES_WINDOW; k++) {
        double away = k - middle, value = h_at(values, end - HANNES_WINDOW + k);
        total += value;
        moment += away * value;
        square += away * away;
    }
    *slope = moment / (square * HANNES_PERIOD);
    return total / HANNES_WINDOW;
}

static double h_rest(const struct Hannes *h, int32_t first, int32_t end)
{
    double least = h_at(h->level, first);
    for (int32_t k = first; k < end; k++)
        if (h_at(h->level, k) < least) least = h_at(h->level, k);
    return least;
}

static void h_begin(struct Hannes *h, double free_current)
{
    double start = h_at(h->position, h->touch);
    h->known[H_START] = h->known[H_LAST] = start;
    h->known[H_FREE] = free_current;
    if (h->touch >= HANNES_WINDOW) h_line(h->position, h->touch, &h->known[H_FREE_SPEED]);
}

static void h_go_on(struct Hannes *h, double current, double position)
{
    double *known = h->known, rise = current - known[H_FREE], travel = position - known[H_START];
    known[H_WORK] += rise * (position - known[H_LAST]);
    known[H_LAST] = position;
    known[H_PEAK] = h_more(known[H_PEAK], rise);
    known[H_FARTHEST] = h_more(known[H_FARTHEST], travel);
    for (int k = 0; k < HANNES_LEVELS; k++)
        if (h->passed[k] < 0.0 && travel >= hannes_levels[k]) h->passed[k] = h_more(rise, 0.0);
}

static void h_of_window(struct Hannes *h, int32_t end)
{
    float *out = h->row;
    double slope, asked, place;
    memset(out, 0, sizeof h->row);
    out[0] = (float)h_line(h->current, end, &slope);
    out[1] = (float)slope;
    place = h_line(h->position, end, &slope);
    out[2] = (float)slope;
    asked = h_line(h->reference, end, &slope);
    out[3] = (float)slope;
    out[4] = (float)(asked - place);
    out[5] = (float)h_line(h->current, end - HANNES_WINDOW, &slope);
    h_line(h->position, end - HANNES_WINDOW, &slope);
    out[6] = (float)slope;
}

static void h_of_grasp(struct Hannes *h, double position, int32_t since)
{
    float *out = h->row;
    double *known = h->known, current = out[0], slope = out[1], speed = out[2];
    double peak = known[H_PEAK], farthest = known[H_FARTHEST];
    double rise = current - known[H_FREE], travel = position - known[H_START];
    double secant = peak / h_more(farthest, 0.05);
    double tangent = slope / copysign(h_more(fabs(speed), 0.3), speed), square = h_more(farthest, 0.1);
    if (speed > 0.3 && since + 1 >= HANNES_WINDOW)
        known[H_STEEPEST] = h_more(known[H_STEEPEST], tangent);
    out[7] = (float)known[H_FREE];
    out[8] = (float)known[H_FREE_SPEED];
    out[H_SINCE] = (float)(since * HANNES_PERIOD);
    out[H_RISE] = (float)rise;
    out[11] = (float)travel;
    out[12] = (float)(rise / h_more(travel, 0.05));
    out[13] = (float)tangent;
    out[14] = (float)(speed / h_more(known[H_FREE_SPEED], 1.0));
    out[15] = (float)peak;
    out[16] = (float)farthest;
    out[17] = (float)secant;
    out[18] = (float)known[H_WORK];
    out[19] = (float)(known[H_WORK] / (square * square));
    out[20] = (float)(peak - rise);
    out[H_TOUCH] = (float)known[H_START];
    out[22] = (float)known[H_STEEPEST];
    for (int k = 0; k < HANNES_LEVELS; k++)
        out[23 + k] = (float)(h->passed[k] >= 0.0 ? h->passed[k] : hannes_levels[k] * secant);
}

/* Looks for the touch; returns the current that counts as free. */
static double h_look(struct Hannes *h, int32_t n)
{
    double level = h_at(h->level, n), least = level;
    if (h->begun < 0 && fabs(h_at(h->position, n) - h->first) > HANNES_MOVED)
        h->begun = n + HANNES_STARTING;
    if (h->touch < 0 && 0 <= h->begun && h->begun < n) {
        int32_t first = n - HANNES_MEMORY > h->begun ? n - HANNES_MEMORY : h->begun;
        least = h_rest(h, first, n);
        if (level > least + HANNES_STEP) {
            h->touch = n;
            while (h->touch > first && h_at(h->level, h->touch) > least + HANNES_BACK) h->touch--;
            h_begin(h, least);
        }
    }
    return least;
}

static void h_take(struct Hannes *h, double current, double position, double reference)
{
    int32_t n = (int32_t)h->count++;
    uint32_t place = (uint32_t)n & (HANNES_KEPT - 1u);
    if (!n) h->first = position;
    h->current[place] = current;
    h->position[place] = position;
    h->reference[place] = reference;
    h->running += current - (n >= HANNES_SMOOTH ? h_at(h->current, n - HANNES_SMOOTH) : 0.0);
    h->level[place] = h->running / (n + 1 < HANNES_SMOOTH ? n + 1 : HANNES_SMOOTH);
#if HANNES_NETS
    if (n / HANNES_BIN < HANNES_BINS) {
        h->bins[0][n / HANNES_BIN] += current;
        h->bins[1][n / HANNES_BIN] += position;
        h->bins[2][n / HANNES_BIN] += reference;
    }
#endif
}

/* ---- trees ------------------------------------------------------------------------------------- */

/* Inner nodes and leaves stand in preorder: a left child comes next, and a tree has one leaf more
 * than inner nodes, so that the way to a leaf says its place. Thresholds are rounded down to float,
 * which decides the same of a float. */
static double h_leaf(const struct HannesForest *f, uint32_t tree, const float *row)
{
    uint32_t node = f->start[tree], leaf = node + tree;
    if (node == f->start[tree + 1u]) return f->value[f->place ? f->place[leaf] : leaf];
    for (;;) {
        uint8_t what = f->feature[node];
        if (row[what & 63u] <= f->threshold[node]) {
            if (what & 128u) break;
            node++;
        } else {
            uint32_t passed = (f->far ? f->far[node] : f->left[node]) + 1u;
            leaf += passed;
            if (what & 64u) break;
            node += passed;
        }
    }
    return f->value[f->place ? f->place[leaf] : leaf];
}

static double h_mean(const struct HannesForest *f, const float *row)
{
    double total = 0.0;
    for (uint32_t tree = 0; tree < f->trees; tree++) total += h_leaf(f, tree, row);
    return total / f->trees;
}

static void h_sink(double *values, uint32_t at, uint32_t count)
{
    double value = values[at];
    for (uint32_t child = 2u * at + 1u; child < count; child = 2u * at + 1u) {
        if (child + 1u < count && values[child + 1u] > values[child]) child++;
        if (values[child] <= value) break;
        values[at] = values[child];
        at = child;
    }
    values[at] = value;
}

static void h_sort(double *values, uint32_t count)
{
    for (uint32_t k = count / 2u; k-- > 0;) h_sink(values, k, count);
    for (uint32_t end = count; end-- > 1u;) {
        double most = values[0];
        values[0] = values[end];
        values[end] = most;
        h_sink(values, 0, end);
    }
}

/* 10, 50 and 90 % quantiles over trees. */
static void h_quantiles(const struct HannesForest *f, const float *row, double *scratch, double *out)
{
    static const double shares[3] = {0.1, 0.5, 0.9};
    for (uint32_t tree = 0; tree < f->trees; tree++) scratch[tree] = h_leaf(f, tree, row);
    h_sort(scratch, f->trees);
    for (int k = 0; k < 3; k++) {
        double place = shares[k] * (f->trees - 1u);
        uint32_t low = (uint32_t)place, high = low + 1u < f->trees ? low + 1u : f->trees - 1u;
        out[k] = scratch[low] + (place - low) * (scratch[high] - scratch[low]);
    }
}

/* ---- stiffness by traces ----------------------------------------------------------------------- */

#if HANNES_NETS
static double h_group(const double *bins, int32_t first)
{
    double total = 0.0;
    for (int32_t b = 0; b < HANNES_GROUP; b++) total += bins[first + b];
    return total / (HANNES_GROUP * HANNES_BIN);
}

static void h_inputs(const struct Hannes *h, double *out)
{
    int32_t first = h->touch / HANNES_BIN - HANNES_GROUP * HANNES_BEFORE;
    for (int32_t g = 0; g < HANNES_TRACE + HANNES_START; g++) {
        bool starting = g >= HANNES_TRACE;
        int32_t bin = HANNES_GROUP * (starting ? g - HANNES_TRACE : g) + (starting ? 0 : first);
        double current = h_group(h->bins[0], bin), place = h_group(h->bins[1], bin);
        double lag = h_group(h->bins[2], bin) - place;
        if (starting) {
            out[2 * HANNES_TRACE + g] = current;
            out[2 * HANNES_TRACE + HANNES_START + g] = lag;
        } else {
            out[g] = current;
            out[HANNES_TRACE + g] = place - h->known[H_START];
            out[2 * HANNES_TRACE + g] = lag;
        }
    }
    out[HANNES_INPUTS - 2] = h->known[H_START];
    out[HANNES_INPUTS - 1] = h->touch * HANNES_PERIOD;
}

static void h_layer(const float *weights, const double *values, int32_t count, bool bounded,
                    double *out, int32_t units)
{
    for (int32_t k = 0; k < units; k++, weights += count + 1) {
        double total = weights[count];
        for (int32_t j = 0; j < count; j++) total += (double)weights[j] * values[j];
        out[k] = total > 0.0 || !bounded ? total : 0.0;
    }
}

static void h_pressed(const struct Hannes *h, double *said)
{
    double in[HANNES_INPUTS], point[HANNES_POINTS + HANNES_HAND] = {0.0};
    double wide[HANNES_FIRST], narrow[HANNES_SECOND];
    double total = 0.0, one, error = h->hand ? HANNES_ERROR_KNOWN : HANNES_ERROR;
    h_inputs(h, in);
    for (int32_t k = 0; k < HANNES_POINTS; k++) {
        point[k] = 0.0;
        for (int32_t j = 0; j < HANNES_INPUTS; j++)
            point[k] += (double)hannes_mix[k * HANNES_INPUTS + j] * (in[j] - hannes_centre[j]);
        if (!(fabs(point[k]) <= HANNES_REACH)) return;
    }
    for (int32_t k = 0; h->hand && k < HANNES_HAND; k++) point[HANNES_POINTS + k] = h->hand[k];
    for (int32_t net = 0; net < HANNES_NETS; net++) {
        h_layer(hannes_first + net * HANNES_FIRST * (HANNES_POINTS + HANNES_HAND + 1), point,
                HANNES_POINTS + HANNES_HAND, true, wide, HANNES_FIRST);
        h_layer(hannes_second + net * HANNES_SECOND * (HANNES_FIRST + 1), wide, HANNES_FIRST, true,
                narrow, HANNES_SECOND);
        h_layer(hannes_last + net * (HANNES_SECOND + 1), narrow, HANNES_SECOND, false, &one, 1);
        total += one;
    }
    said[0] = exp(total / HANNES_NETS);
    said[1] = exp(total / HANNES_NETS - error);
    said[2] = exp(total / HANNES_NETS + error);
}

/* Once, where the traces are long enough. */
static void h_ask(struct Hannes *h)
{
    int32_t bin = h->touch / HANNES_BIN;
    if (h->asked || h->touch < 0 || bin < HANNES_EARLIEST || bin >= HANNES_LATEST) return;
    if ((int32_t)h->count < (bin + HANNES_GROUP * HANNES_AFTER) * HANNES_BIN) return;
    h->asked = true;
    h_pressed(h, h->pressed);
}
#endif

#if HANNES_HAND
void hannes_empty_reset(struct HannesEmpty *e)
{
    memset(e, 0, sizeof *e);
}

/* What the networks see of a whole closure; false where it is unlike those that were learned from. */
static bool h_hand(struct HannesEmpty *e)
{
    for (int32_t k = 0; k < HANNES_HAND; k++) {
        double total = 0.0;
        for (int32_t j = 0; j < HANNES_NUMBERS; j++)
            total += (double)hannes_hand_mix[k * HANNES_NUMBERS + j]
                * (e->means[j] - hannes_hand_centre[j]);
        if (!(fabs(total) <= hannes_hand_reach[k])) return false;
        e->point[k] = total;
    }
    return true;
}

bool hannes_empty(struct HannesEmpty *e, double current, double position, double reference)
{
    if (e->count >= HANNES_NUMBERS / 2 * HANNES_MEAN) return e->known;
    uint32_t mean = e->count++ / HANNES_MEAN;
    e->current += current;
    e->lag += reference - position;
    if (e->count % HANNES_MEAN) return false;
    e->means[mean] = e->current / HANNES_MEAN;
    e->means[HANNES_NUMBERS / 2 + mean] = e->lag / HANNES_MEAN;
    e->current = e->lag = 0.0;
    if (e->count == HANNES_NUMBERS / 2 * HANNES_MEAN) e->known = h_hand(e);
    return e->known;
}

double hannes_empty_command(double since)
{
    const double *times = hannes_empty_times, *angles = hannes_empty_angles;
    uint32_t k = 1;
    if (!(since > times[0])) return angles[0];
    while (k + 1 < HANNES_EMPTY_POINTS && times[k] < since) k++;
    if (!(since < times[k])) return angles[k];
    return angles[k - 1]
        + (since - times[k - 1]) / (times[k] - times[k - 1]) * (angles[k] - angles[k - 1]);
}

void hannes_know(struct Hannes *h, const struct HannesEmpty *e)
{
    h->hand = e->known ? e->point : NULL;
}
#endif

/* ---- decision ---------------------------------------------------------------------------------- */

/* On the line through points (x, y), constant beyond them. */
static double h_between(double at, const double *x, const double *y, uint32_t count)
{
    uint32_t low = 0, high = count;
    if (at < x[0]) return y[0];
    if (at >= x[count - 1u]) return y[count - 1u];
    while (high - low > 1u) {
        uint32_t middle = low + (high - low) / 2u;
        if (at >= x[middle]) low = middle;
        else high = middle;
    }
    if (x[low] == at) return y[low];
    return (y[low + 1u] - y[low]) / (x[low + 1u] - x[low]) * (at - x[low]) + y[low];
}

static void h_estimate(double logarithm, double apart, const struct HannesBand *band, double *out)
{
    out[0] = exp(logarithm);
    out[1] = out[0] * exp(h_between(apart, band->x, band->low, band->count));
    out[2] = out[0] * exp(h_between(apart, band->x, band->high, band->count));
}

/* Median of the last `count` of the values that the ring of held windows keeps. */
static double h_median(const double *ring, uint32_t held, uint32_t count, double *scratch)
{
    for (uint32_t k = 0; k < count; k++) scratch[k] = ring[(held - count + k) % HANNES_HELD];
    h_sort(scratch, count);
    return count % 2u ? scratch[count / 2u] : (scratch[count / 2u - 1u] + scratch[count / 2u]) / 2.0;
}

static void h_stiffness(struct Hannes *h, bool holds, double *out)
{
    double q[3];
    if (holds) {
        h_quantiles(&hannes_stiffness, h->row, h->scratch, q);
        h->log_stiffness[h->held % HANNES_HELD] = q[1];
        h->apart[h->held % HANNES_HELD] = q[2] - q[0];
        h->held++;
    }
    uint32_t later = h->held - h->held / 2u;
    if (later > HANNES_HELD) later = HANNES_HELD;
    double value = h_median(h->log_stiffness, h->held, later, h->scratch);
    h_estimate(value, h_median(h->apart, h->held, later, h->scratch), &hannes_stiffness_band, out);
}

static void h_decide(struct Hannes *h, struct HannesDecision *said)
{
    bool touched = h->row[H_SINCE] > 0.0f, holds = touched && h->row[H_RISE] > (float)HANNES_HOLD;
    double odds = HANNES_NO_CONTACT, q[3];
    memset(said, 0, sizeof *said);
    said->window = h_between(h_mean(&hannes_rigid, h->row), hannes_calibration_x,
                             hannes_calibration_y, HANNES_CALIBRATION);
    if (touched) {
        double inside = said->window < 1e-6 ? 1e-6 : said->window;
        if (inside > 1.0 - 1e-6) inside = 1.0 - 1e-6;
        odds = log(inside) - log1p(-inside);
        if (odds < -HANNES_EXTREME) odds = -HANNES_EXTREME;
        if (odds > HANNES_EXTREME) odds = HANNES_EXTREME;
    }
    h->odds += HANNES_SHARE * (odds - h->odds);
    said->touched = touched;
    said->touch = h->row[H_TOUCH];
    said->held = holds;
    said->stiff = holds || h->held;
    said->rigid = said->stiff ? 1.0 / (1.0 + exp(-h->odds)) : 0.5;
    if (h_more(said->rigid, 1.0 - said->rigid) < HANNES_SURE) said->word = HANNES_UNKNOWN;
    else said->word = said->rigid >= 0.5 ? HANNES_RIGID : HANNES_SOFT;
    if (said->stiff) h_stiffness(h, holds, said->stiffness);
#if HANNES_NETS
    h_ask(h);
#endif
    memcpy(said->pressed, h->pressed, sizeof h->pressed);
    if (!holds) return;
    h_quantiles(&hannes_force, h->row, h->scratch, q);
    h_estimate(q[1], q[2] - q[0], &hannes_force_band, said->force);
}

void hannes_reset(struct Hannes *h)
{
    memset(h, 0, sizeof *h);
    h->begun = h->touch = -1;
    for (int k = 0; k < HANNES_LEVELS; k++) h->passed[k] = -1.0;
}

bool hannes_sample(struct Hannes *h, double current, double position, double reference,
                   struct HannesDecision *said)
{
    if (h->count > HANNES_LONGEST) {
        const double *hand = h->hand;
        hannes_reset(h);
        h->hand = hand;
    }
    h_take(h, current, position, reference);
    int32_t n = (int32_t)h->count - 1, seen = n + 1;
    double least = h_look(h, n), level = h_at(h->level, n);
    if (h->touch >= 0) h_go_on(h, level, position);
    if (seen < 2 * HANNES_WINDOW || (seen - 2 * HANNES_WINDOW) % HANNES_HOP) return false;
    h_of_window(h, seen);
    h->row[7] = (float)least;
    h->row[8] = h->row[2];
    h->row[H_RISE] = (float)(level - least);
    h->row[H_TOUCH] = (float)position;
    if (h->touch >= 0) h_of_grasp(h, position, n - h->touch);
    h_decide(h, said);
    return true;
}

/* ---- grip policy ------------------------------------------------------------------------------- */

static double g_within(double value, double low, double high)
{
    double raised = low > value ? low : value;
    return high < raised ? high : raised;
}

void hannes_grip_reset(struct HannesGrip *g)
{
    memset(g, 0, sizeof *g);
    g->mean = 0.5;
}

bool hannes_again(struct HannesGrip *g, double position)
{
    if (!g->released) return false;
    if (position < g->lowest) g->lowest = position;
    g->released = position < g->lowest + HANNES_TURN;
    return !g->released;
}

/* What recognition last said of the object, until the hand has let it go. */
static void g_hold(struct HannesGrip *g, const struct HannesDecision *fresh, double position)
{
    if (g->released) return;
    if (fresh && fresh->held) {
        g->force = fresh->force[0];
        g->force_high = fresh->force[2];
    }
    if (fresh && fresh->touched) {
        g->held = true;
        g->touch = fresh->touch;
        g->rigid = fresh->rigid;
        g->stiffness = fresh->pressed[0] / HANNES_BORDER;
    }
    if (g->held && position < g->touch - HANNES_RETREAT) {
        g->held = false;
        g->released = true;
        g->lowest = position;
    }
}

static double g_offset(const struct HannesGrip *g, double period, double position, double most,
                       double force_wanted)
{
    double rate = HANNES_FORCE_GAIN * (force_wanted - (g->firm ? g->force : g->force_high));
    double start = g->since > 0.0 ? g->offset : position - g->touch, offset;
    rate = g_within(rate, -HANNES_FORCE_SPEED, HANNES_FORCE_SPEED);
    offset = start + rate * period;
    return offset != offset ? 0.0 : g_within(offset, 0.0, most);
}

static double g_free(struct HannesGrip *g, double set_point, double since, double certain,
                     double mean)
{
    g->since = since;
    g->certain = certain;
    g->mean = mean;
    g->share = g->offset = 0.0;
    return g->set_point = set_point;
}

static double g_passing(double last, double period)
{
    double slowly = last + HANNES_APPROACH_SPEED * period;
    if (slowly > HANNES_FREE_TO) slowly = HANNES_FREE_TO;
    slowly = h_more(slowly, last + HANNES_FREE_SPEED * period);
    return h_more(HANNES_APPROACH_FROM, slowly);
}

static bool g_firm(const struct HannesGrip *g, double mean, double certain, double since)
{
    if (g->firm) return mean >= HANNES_SOFT_BELOW;
    if (certain >= HANNES_DWELL) return true;
    return since >= HANNES_PATIENCE && mean > HANNES_DECIDE_FROM;
}

static double g_firm_share(const struct HannesGrip *g, bool was_firm, double since)
{
    double more = HANNES_LATE * h_more(since - HANNES_SETTLE, 0.0);
    if (was_firm) return g->share > 1.0 ? g->share : 1.0;
    return 1.0 + (more < HANNES_LATE_MOST ? more : HANNES_LATE_MOST);
}

static double g_soft_share(const struct HannesGrip *g, bool presses, double beyond, double period)
{
    double goal = presses ? HANNES_PROBE_SHARE : HANNES_SOFT_SHARE;
    double step = HANNES_PROBE_SPEED * period / h_more(beyond, 0.1);
    double start = g_within(g->share, HANNES_SOFT_SHARE, HANNES_PROBE_SHARE);
    return g_within(goal, start - step, start + step);
}

double hannes_grip(struct HannesGrip *g, const struct HannesDecision *fresh, double period,
                   double wanted, double position, double force_wanted)
{
    g_hold(g, fresh, position);
    if (!g->begun) g->set_point = position;
    g->begun = true;
    if (!g->held) {
        double free = g_passing(g->set_point, period);
        g->firm = g->uncertain = false;
        return g_free(g, free < wanted ? free : wanted, 0.0, 0.0, 0.5);
    }
    double since = g->since + period, most = HANNES_GRIP_SPEED * period;
    double certain = g->rigid >= HANNES_RIGID_FROM ? g->certain + period : 0.0;
    double beyond = wanted - g->touch, share, offset, half = 0.5 * period;
    double rate = period / HANNES_AVERAGING;
    double mean = g->mean + (rate < 1.0 ? rate : 1.0) * (g->rigid - g->mean);
    bool was_firm = g->firm, known = g->uncertain && g->stiffness > 0.0;
    bool doubt = since >= HANNES_SETTLE && g->rigid > HANNES_DOUBT_FROM;
    if (known) g->firm = g->stiffness >= HANNES_STIFF_FROM && mean >= HANNES_SOFT_BELOW;
    else g->firm = g_firm(g, mean, certain + half, since + half);
    g->uncertain = known || (!g->firm && (g->uncertain || (doubt && since < HANNES_DOUBT_UNTIL)));
    if (beyond <= 0.0) return g_free(g, wanted, since, certain, mean); /* command to open */
    if (g->firm) share = g_firm_share(g, was_firm, since);
    else share = g_soft_share(g, !known && (doubt || (g->uncertain && since < HANNES_PATIENCE)), beyond, period);
    offset = share * beyond;
    if (force_wanted > 0.0) offset = g_offset(g, period, position, offset, force_wanted);
    g->since = since;
    g->certain = certain;
    g->mean = mean;
    g->share = share;
    g->offset = offset;
    g->set_point = g_within(g->touch + offset, g->set_point - most, g->set_point + most);
    return g->set_point;
}
