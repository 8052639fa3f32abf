/* Reference firmware of a board that drives a Hannes hand: one file, no allocation, C99.
 *
 * It speaks the protocol of hannes/bench/messages.py and follows the rules of board_logic.py: the
 * tests compile this file as a host program and compare its bytes with that.
 *
 * To put it on a microcontroller (written with an STM32G4 at 170 MHz in mind, nothing in it is
 * special to that one): call board_init() once, board_byte() for each byte that the UART received,
 * and board_tick() from a timer every 1 ms; provide the two functions under "hardware".
 * With -DHANNES_STRATEGY='"recogniser.c"', a file of `hannes export-c`, the board also recognises what
 * it holds and limits its grip: board_grasp(), called from a switch, needs no host. board_empty(),
 * called once with the hand open and empty, lets it know its hand; until then that is a middle one.
 * board_init() forgets the hand: keep `empty` before, and put it back after. Its numbers belong to
 * the networks of one exported file: after another export, close on nothing anew.
 * A struct Board is all the memory there is: sizeof(struct Board), some 60 KiB as set below.
 */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#ifdef HANNES_STRATEGY
#include HANNES_STRATEGY
#endif

#ifndef RING
#define RING 256u /* frames kept to be sent again */
#endif
#ifndef PROFILE_POINTS
#define PROFILE_POINTS 4096u
#endif
#define RATE 1000u         /* Hz */
#define PERIOD (1000000u / RATE)
#define WATCHDOG 200000u   /* us */
#define PULSE_PERIOD 100000
#define VERSION 1u
#define FIRMWARE "hannes reference 1"
#define LONGEST 254u
#define AT_ONCE 8u
#define HEADER 13u
#define CHECK 4u
#define MICRO 1e-6

/* ---- hardware: what the board provides ------------------------------------------------------ */

/* Send bytes; must not wait longer than a tick. */
void hardware_send(const uint8_t *bytes, size_t count);
/* One tick of the drive towards `reference` [rad]; `open`: no current. Fills CHANNELS values. */
void hardware_step(bool open, double reference, double *values);

/* ---- channels: what telemetry has, in order -------------------------------------------------- */

struct Channel {
    const char *name, *unit;
    char code; /* as in Python's struct: h 16 bit, i 32 bit, signed */
    double scale;
};
#define CHANNELS 3u
enum { REFERENCE_CHANNEL, POSITION_CHANNEL, CURRENT_CHANNEL };
static const struct Channel channels[CHANNELS] = {
    {"reference", "rad", 'i', 1e-6},
    {"position", "rad", 'i', 1e-6},
    {"current", "A", 'h', 1e-3},
};
#define MOST_CURRENT 6.0    /* A */
#define LEAST_TRAVEL (-1.0) /* rad */
#define MOST_TRAVEL 40.0

/* ---- what frames carry ------------------------------------------------------------------------ */

enum {
    ASK = 1, ALIVE, PROFILE, POINTS, START, SET_POINT, STOP, RESEND,
    HELLO = 32, CHANNEL, TELEMETRY, PULSE, ANSWER
};
enum { IDLE, RUNNING, FOLLOWING, STOPPED, BY_WATCHDOG, OVER_CURRENT, OVER_TEMPERATURE, OVER_TRAVEL };
enum { DONE, UNKNOWN, INCOMPLETE, BEYOND_LIMITS, BUSY, NOT_KEPT, TOO_LONG };

struct Frame {
    uint8_t kind, size;
    uint32_t sequence;
    uint64_t time;
    uint8_t payload[LONGEST - HEADER - CHECK];
};
struct Kept { /* the longest that is kept is a hello */
    uint8_t kind, size;
    uint32_t sequence;
    uint64_t time;
    uint8_t payload[48];
};
struct Board {
    uint8_t state, packet[LONGEST + 2u];
    bool too_long;
    size_t filled;
    uint64_t time, heard, began;
    int64_t pulsed;
    uint32_t sequence, beat, refused, dropped;
    struct Kept ring[RING];
    uint32_t kept; /* frames that were ever put into the ring */
    uint32_t at_time[PROFILE_POINTS];
    int32_t at_value[PROFILE_POINTS];
    uint8_t there[(PROFILE_POINTS + 7u) / 8u];
    bool expected;
    uint32_t points, duration, check, at;
    double reference;
#ifdef HANNES_STRATEGY
    bool alone; /* a grasp of the board's own: it goes on without a host */
    double goal, command, force_wanted, position;
    struct Hannes hannes;
    struct HannesGrip grip;
    struct HannesDecision said;
#if HANNES_HAND
    bool empties; /* a closure on nothing of the board's own is under way */
    struct HannesEmpty empty;
#endif
#endif
};
#ifdef HANNES_STRATEGY
#define IS_ALONE(b) ((b)->alone)
#define GRASP_SPEED 15.4 /* rad/s, of the command */
#define MOST_OFF 0.5     /* rad by which an open hand may be closed */
#else
#define IS_ALONE(b) false
#endif

/* ---- little-endian numbers, CRC-32, COBS ------------------------------------------------------ */

static uint64_t get(const uint8_t *from, unsigned bytes)
{
    uint64_t value = 0;
    for (unsigned k = 0; k < bytes; k++) value |= (uint64_t)from[k] << (8u * k);
    return value;
}

static uint8_t *put(uint8_t *to, uint64_t value, unsigned bytes)
{
    for (unsigned k = 0; k < bytes; k++) *to++ = (uint8_t)(value >> (8u * k));
    return to;
}

static uint32_t crc32(uint32_t crc, const uint8_t *bytes, size_t count)
{
    crc = ~crc;
    while (count--) {
        crc ^= *bytes++;
        for (int k = 0; k < 8; k++) crc = crc & 1u ? crc >> 1 ^ 0xEDB88320u : crc >> 1;
    }
    return ~crc;
}

static size_t stuff(const uint8_t *body, size_t count, uint8_t *packet)
{
    size_t mark = 0, to = 1;
    uint8_t run = 1;
    for (size_t k = 0; k < count; k++) {
        if (body[k]) {
            packet[to++] = body[k];
            run++;
        }
        if (!body[k] || run == 0xFF) {
            packet[mark] = run;
            mark = to++;
            run = 1;
        }
    }
    packet[mark] = run;
    packet[to++] = 0;
    return to;
}

static size_t unstuff(const uint8_t *packet, size_t count, uint8_t *body)
{
    size_t to = 0, from = 0;
    while (from < count) {
        uint8_t run = packet[from++];
        if (!run || from + run - 1u > count) return 0;
        for (uint8_t k = 1; k < run; k++) body[to++] = packet[from++];
        if (run < 0xFF && from < count) body[to++] = 0;
    }
    return to;
}

/* ---- sending ----------------------------------------------------------------------------------- */

static void send_frame(uint8_t kind, uint32_t sequence, uint64_t time, const uint8_t *payload, uint8_t size)
{
    uint8_t body[LONGEST], packet[LONGEST + 3u], *end = body;
    end = put(end, kind, 1);
    end = put(end, sequence, 4);
    end = put(end, time, 8);
    memcpy(end, payload, size);
    end += size;
    end = put(end, crc32(0, body, (size_t)(end - body)), 4);
    hardware_send(packet, stuff(body, (size_t)(end - body), packet));
}

static void emit(struct Board *b, uint8_t kind, const uint8_t *payload, uint8_t size)
{
    struct Kept *kept = &b->ring[b->kept++ % RING];
    kept->kind = kind;
    kept->size = size;
    kept->sequence = b->sequence++;
    kept->time = b->time;
    memcpy(kept->payload, payload, size);
    send_frame(kind, kept->sequence, kept->time, payload, size);
}

static void pulse(struct Board *b)
{
    uint8_t payload[13], *end = payload;
    end = put(end, b->state, 1);
    end = put(end, b->beat, 4);
    end = put(end, b->refused, 4);
    put(end, b->dropped, 4);
    emit(b, PULSE, payload, sizeof payload);
}

static void introduce(struct Board *b)
{
    uint8_t payload[43] = {0}, *end = payload;
    end = put(end, VERSION, 2);
    strncpy((char *)end, FIRMWARE, 24);
    end = put(end + 24, RATE, 4);
    end = put(end, WATCHDOG, 4);
    end = put(end, RING, 4);
    end = put(end, PROFILE_POINTS, 4);
    put(end, CHANNELS, 1);
    emit(b, HELLO, payload, sizeof payload);
    for (unsigned k = 0; k < CHANNELS; k++) {
        uint8_t each[34] = {0};
        uint64_t bits;
        memcpy(&bits, &channels[k].scale, 8);
        each[0] = (uint8_t)k;
        strncpy((char *)each + 1, channels[k].name, 16);
        strncpy((char *)each + 17, channels[k].unit, 8);
        each[25] = (uint8_t)channels[k].code;
        put(each + 26, bits, 8);
        emit(b, CHANNEL, each, sizeof each);
    }
}

static void answer(struct Board *b, const struct Frame *frame, uint8_t reason)
{
    uint8_t payload[6], *end = put(payload, frame->sequence, 4);
    end = put(end, frame->kind, 1);
    put(end, reason, 1);
    b->refused += reason != DONE;
    emit(b, ANSWER, payload, sizeof payload);
}

/* ---- requests ---------------------------------------------------------------------------------- */

static bool moving(const struct Board *b)
{
    return b->state == RUNNING || b->state == FOLLOWING;
}

static bool within(int32_t reference)
{
    return LEAST_TRAVEL <= reference * MICRO && reference * MICRO <= MOST_TRAVEL;
}

/* A host leads from now on: its silence stops the board. */
static void attended(struct Board *b)
{
#ifdef HANNES_STRATEGY
    b->alone = false;
#else
    (void)b;
#endif
}

static uint8_t expect(struct Board *b, const uint8_t *payload)
{
    if (moving(b)) return BUSY;
    if (get(payload, 4) > PROFILE_POINTS) return TOO_LONG;
    b->points = (uint32_t)get(payload, 4);
    b->duration = (uint32_t)get(payload + 4, 4);
    b->check = (uint32_t)get(payload + 8, 4);
    b->expected = true;
    memset(b->there, 0, sizeof b->there);
    return DONE;
}

static uint8_t take_points(struct Board *b, const uint8_t *payload)
{
    uint32_t first = (uint32_t)get(payload, 4);
    if (!b->expected) return INCOMPLETE;
    for (uint32_t k = 0; k < AT_ONCE; k++) {
        uint32_t place = first + k;
        if (place >= b->points || place < first) continue;
        b->at_time[place] = (uint32_t)get(payload + 4u + 8u * k, 4);
        b->at_value[place] = (int32_t)(uint32_t)get(payload + 8u + 8u * k, 4);
        b->there[place / 8u] |= (uint8_t)(1u << place % 8u);
    }
    return DONE;
}

static uint8_t start(struct Board *b, const uint8_t *payload)
{
    uint32_t check = 0;
    bool inside = true;
    if (moving(b)) return BUSY;
    if (!b->expected || !b->points) return INCOMPLETE;
    for (uint32_t k = 0; k < b->points; k++) {
        uint8_t point[8];
        if (!(b->there[k / 8u] >> k % 8u & 1u)) return INCOMPLETE;
        put(put(point, b->at_time[k], 4), (uint32_t)b->at_value[k], 4);
        check = crc32(check, point, sizeof point);
        inside = inside && within(b->at_value[k]);
    }
    if (check != b->check || get(payload, 4) != check) return INCOMPLETE;
    if (!inside) return BEYOND_LIMITS;
    b->state = RUNNING;
    attended(b);
    b->began = b->time;
    b->at = 0;
    return DONE;
}

static uint8_t follow(struct Board *b, const uint8_t *payload)
{
    int32_t reference = (int32_t)(uint32_t)get(payload, 4);
    if (b->state == RUNNING || (moving(b) && IS_ALONE(b))) return BUSY;
    if (!within(reference)) return BEYOND_LIMITS;
    b->state = FOLLOWING;
    b->reference = reference * MICRO;
    attended(b);
    return DONE;
}

static bool send_again(const struct Board *b, const uint8_t *payload)
{
    uint32_t first = (uint32_t)get(payload, 4), count = (uint32_t)get(payload + 4, 2);
    uint32_t have = b->kept < RING ? b->kept : RING;
    bool found = false;
    for (uint32_t k = b->kept - have; k != b->kept; k++) {
        const struct Kept *kept = &b->ring[k % RING];
        if (kept->sequence - first >= count) continue;
        send_frame(kept->kind, kept->sequence, kept->time, kept->payload, kept->size);
        found = true;
    }
    return found;
}

static int host_size(uint8_t kind)
{
    static const int sizes[] = {-1, 2, 4, 12, 4 + 8 * (int)AT_ONCE, 4, 4, 1, 6};
    return kind < sizeof sizes / sizeof *sizes ? sizes[kind] : -1;
}

static void hear(struct Board *b, const struct Frame *frame)
{
    const uint8_t *payload = frame->payload;
    b->heard = b->time;
    switch (frame->kind) {
    case ASK: introduce(b); break;
    case ALIVE: b->beat = (uint32_t)get(payload, 4); pulse(b); break;
    case PROFILE: answer(b, frame, expect(b, payload)); break;
    case POINTS: answer(b, frame, take_points(b, payload)); break;
    case START: answer(b, frame, start(b, payload)); break;
    case SET_POINT: answer(b, frame, follow(b, payload)); break;
    case STOP: b->state = STOPPED; answer(b, frame, DONE); break;
    case RESEND: if (!send_again(b, payload)) answer(b, frame, NOT_KEPT); break;
    }
}

static void packet_done(struct Board *b)
{
    uint8_t body[LONGEST + 2u];
    struct Frame frame;
    size_t count = unstuff(b->packet, b->filled, body);
    bool sound = !b->too_long && count >= HEADER + CHECK && count <= LONGEST
        && host_size(body[0]) == (int)(count - HEADER - CHECK)
        && crc32(0, body, count - CHECK) == get(body + count - CHECK, 4);
    if (!sound) {
        b->dropped++;
        return;
    }
    frame.kind = body[0];
    frame.size = (uint8_t)(count - HEADER - CHECK);
    frame.sequence = (uint32_t)get(body + 1, 4);
    frame.time = get(body + 5, 8);
    memcpy(frame.payload, body + HEADER, frame.size);
    hear(b, &frame);
}

/* ---- what the program calls -------------------------------------------------------------------- */

void board_init(struct Board *b)
{
    memset(b, 0, sizeof *b);
    b->pulsed = -PULSE_PERIOD;
}

void board_byte(struct Board *b, uint8_t byte)
{
    if (byte) {
        if (b->filled < sizeof b->packet) b->packet[b->filled++] = byte;
        else b->too_long = true;
        return;
    }
    if (b->filled) packet_done(b);
    b->filled = 0;
    b->too_long = false;
}

static bool wanted(struct Board *b, double *reference)
{
    if (b->state == FOLLOWING) {
        *reference = b->reference;
        return true;
    }
    if (b->state != RUNNING) return false;
    uint64_t since = b->time - b->began;
    if (since > b->duration) {
        b->state = IDLE;
        return false;
    }
    while (b->at + 2u < b->points && b->at_time[b->at + 1u] <= since) b->at++;
    uint32_t first = b->at, second = b->at + 1u;
    if (second >= b->points || since <= b->at_time[first]) *reference = b->at_value[first] * MICRO;
    else if (since >= b->at_time[second]) *reference = b->at_value[second] * MICRO;
    else {
        double share = (double)(since - b->at_time[first])
            / (double)(b->at_time[second] - b->at_time[first]);
        *reference = (b->at_value[first]
            + share * ((double)b->at_value[second] - b->at_value[first])) * MICRO;
    }
    return true;
}

static int64_t raw(double value, const struct Channel *channel)
{
    double scaled = value / channel->scale, most = channel->code == 'h' ? 32767.0 : 2147483647.0;
    if (scaled >= most) return (int64_t)most;
    if (scaled <= -most - 1.0) return (int64_t)(-most - 1.0);
    int64_t whole = (int64_t)scaled;
    double rest = scaled - (double)whole;
    if (rest > 0.5 || (rest == 0.5 && whole % 2)) whole++; /* to even, as Python rounds */
    if (rest < -0.5 || (rest == -0.5 && whole % 2)) whole--;
    return whole;
}

static void limit(struct Board *b, const double *values)
{
    double current = values[CURRENT_CHANNEL], position = values[POSITION_CHANNEL];
    if (!moving(b)) return;
    if (current > MOST_CURRENT || current < -MOST_CURRENT) b->state = OVER_CURRENT;
    else if (position < LEAST_TRAVEL || position > MOST_TRAVEL) b->state = OVER_TRAVEL;
}

#ifdef HANNES_STRATEGY
#if HANNES_RATE != RATE
#error "the model was trained at another rate than the board ticks"
#endif

/* Nothing is known of an object, but of the hand, once it closed on nothing. */
static void new_object(struct Board *b)
{
    hannes_reset(&b->hannes);
#if HANNES_HAND
    hannes_know(&b->hannes, &b->empty);
#endif
}

#if HANNES_HAND
/* Close and open by the command of `empty-closure`, without a host: grasps that follow go by what
 * it shows of the hand. This is not known (b->empty.known) where the closure was stopped, or
 * something was held. False where the hand moves already, or is not open: half closed, its means
 * would be those of another hand. */
bool board_empty(struct Board *b)
{
    double off = b->position - hannes_empty_command(0.0);
    if (moving(b) || off > MOST_OFF || off < -MOST_OFF) return false;
    hannes_empty_reset(&b->empty);
    b->reference = hannes_empty_command(0.0);
    b->began = b->time;
    b->state = FOLLOWING;
    b->alone = b->empties = true;
    return true;
}

/* Take in a tick's sample of it, and find the next tick's reference. */
static void empty_on(struct Board *b, const double *values)
{
    double since = (double)(b->time - b->began + PERIOD) * MICRO;
    hannes_empty(&b->empty, values[CURRENT_CHANNEL], values[POSITION_CHANNEL],
                 values[REFERENCE_CHANNEL]);
    b->reference = hannes_empty_command(since);
    if (since <= HANNES_EMPTY_DURATION) return;
    b->state = IDLE;
    b->alone = b->empties = false;
}
#endif

/* Close (or open) towards `goal` [rad] as far as the grip policy allows, without a host; with
 * `force_wanted` [N] above zero, to that force. False where a host has the board, or it closes on
 * nothing. */
bool board_grasp(struct Board *b, double goal, double force_wanted)
{
    if (!(LEAST_TRAVEL <= goal && goal <= MOST_TRAVEL)) return false;
    if (moving(b) && !b->alone) return false;
#if HANNES_HAND
    if (moving(b) && b->empties) return false;
    b->empties = false;
#endif
    if (!moving(b)) {
        new_object(b);
        hannes_grip_reset(&b->grip);
        b->command = b->reference = b->position;
        b->state = FOLLOWING;
        b->alone = true;
    }
    b->goal = goal;
    b->force_wanted = force_wanted;
    return true;
}

void board_stop(struct Board *b)
{
    b->state = STOPPED;
}

/* Take in a tick's sample, and find the next tick's reference. */
static void grip_on(struct Board *b, const double *values)
{
    double position = values[POSITION_CHANNEL], most = GRASP_SPEED * HANNES_PERIOD;
#if HANNES_HAND
    if (b->empties) {
        empty_on(b, values);
        return;
    }
#endif
    if (hannes_again(&b->grip, position)) new_object(b);
    bool fresh = hannes_sample(&b->hannes, values[CURRENT_CHANNEL], position,
                               values[REFERENCE_CHANNEL], &b->said);
    b->command = g_within(b->goal, b->command - most, b->command + most);
    b->reference = hannes_grip(&b->grip, fresh ? &b->said : NULL, HANNES_PERIOD, b->command,
                               position, b->force_wanted);
}
#endif

void board_tick(struct Board *b)
{
    double values[CHANNELS], reference = 0.0;
    uint8_t payload[4u * CHANNELS], *end = payload;
    if (moving(b) && !IS_ALONE(b) && b->time - b->heard > WATCHDOG) b->state = BY_WATCHDOG;
    bool driven = wanted(b, &reference);
    hardware_step(!driven, reference, values);
#ifdef HANNES_STRATEGY
    b->position = values[POSITION_CHANNEL];
#endif
    limit(b, values);
#ifdef HANNES_STRATEGY
    if (moving(b) && b->alone) grip_on(b, values);
#endif
    for (unsigned k = 0; k < CHANNELS; k++)
        end = put(end, (uint64_t)raw(values[k], &channels[k]), channels[k].code == 'h' ? 2u : 4u);
    emit(b, TELEMETRY, payload, (uint8_t)(end - payload));
    b->time += PERIOD;
    if ((int64_t)b->time - b->pulsed >= PULSE_PERIOD) {
        b->pulsed = (int64_t)b->time;
        pulse(b);
    }
}

/* ---- as a host program: frames on standard input, a tick for each byte FF 00 pair --------------- */

#ifdef HANNES_HOST
#include <stdio.h>

static double shaft;

void hardware_send(const uint8_t *bytes, size_t count)
{
    fwrite(bytes, 1, count, stdout);
}

#ifdef HANNES_STRATEGY
static double slope; /* A/rad, of the current beyond the place of an object */
#define OBJECT_AT 4.0 /* rad */

void hardware_step(bool open, double reference, double *values)
{
    double target = open ? shaft : reference;
    double squeeze = shaft > OBJECT_AT ? shaft - OBJECT_AT : 0.0;
    shaft += 0.06 * (target - shaft - 0.8 * slope * squeeze);
    values[REFERENCE_CHANNEL] = target;
    values[POSITION_CHANNEL] = shaft;
    values[CURRENT_CHANNEL] = (open ? 0.0 : target >= shaft ? 0.25 : -0.125) + slope * squeeze;
}
#else
void hardware_step(bool open, double reference, double *values)
{
    double target = open ? shaft : reference, current = target - shaft;
    shaft += 0.05 * current;
    values[REFERENCE_CHANNEL] = target;
    values[POSITION_CHANNEL] = shaft;
    values[CURRENT_CHANNEL] = current;
}
#endif

/* Input: u8 what (0: bytes, 1: ticks), u16 count; then the bytes. With a strategy also 2: a switch
 * asks for a grasp to `count` mrad; 3: the slope of the object is `count` mA/rad from now on; 4: a
 * switch asks for a closure on nothing. */
int main(void)
{
    static struct Board board;
    uint8_t head[3];
    board_init(&board);
    while (fread(head, 1, 3, stdin) == 3) {
        unsigned count = (unsigned)get(head + 1, 2);
#ifdef HANNES_STRATEGY
        if (head[0] == 2) {
            board_grasp(&board, 1e-3 * count, 0.0);
            continue;
        }
        if (head[0] == 3) {
            slope = 1e-3 * count;
            continue;
        }
#if HANNES_HAND
        if (head[0] == 4) {
            board_empty(&board);
            continue;
        }
#endif
#endif
        for (unsigned k = 0; k < count; k++) {
            if (head[0]) board_tick(&board);
            else {
                int byte = getchar();
                if (byte == EOF) return 1;
                board_byte(&board, (uint8_t)byte);
            }
        }
        fflush(stdout);
    }
    return 0;
}
#endif
