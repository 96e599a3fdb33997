#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FMI_VERSION @VERSION@
#define TOKEN "@TOKEN@"
#define TOLERANCE @TOLERANCE@
#define CATEGORY "logStatusError"

/* Names begin with a prefix where units are linked statically. */
#if defined FMI2_FUNCTION_PREFIX
#define FMI_PREFIX FMI2_FUNCTION_PREFIX
#elif defined FMI3_FUNCTION_PREFIX
#define FMI_PREFIX FMI3_FUNCTION_PREFIX
#else
#define FMI_PREFIX
#endif
#define JOINED(a, b, c) a##b##c
#define NAMED(prefix, version, name) JOINED(prefix, version, name)
#if defined _WIN32
#define EXPORTED __declspec(dllexport)
#elif defined __GNUC__
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif

#if FMI_VERSION == 2
#define VERSION "2.0"
#define FMI(name) NAMED(FMI_PREFIX, fmi2, name)
#define GET_STATE GetFMUstate
#define SET_STATE SetFMUstate
#define FREE_STATE FreeFMUstate
#define SERIALIZED_SIZE SerializedFMUstateSize
#define SERIALIZE SerializeFMUstate
#define DESERIALIZE DeSerializeFMUstate
#define GET_RATES GetDerivatives
typedef int boolean;
typedef char byte;
typedef void (*unit_log)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
  unit_log log;
  void *(*allocate)(size_t, size_t);
  void (*release)(void *);
  void (*finished)(void *, int);
  void *environment;
} callbacks;
typedef struct {
  int again, terminate, nominals, moved, defined;
  double next;
} event_information;
#else
#define VERSION "3.0"
#define FMI(name) NAMED(FMI_PREFIX, fmi3, name)
#define GET_STATE GetFMUState
#define SET_STATE SetFMUState
#define FREE_STATE FreeFMUState
#define SERIALIZED_SIZE SerializedFMUStateSize
#define SERIALIZE SerializeFMUState
#define DESERIALIZE DeserializeFMUState
#define GET_RATES GetContinuousStateDerivatives
typedef bool boolean;
typedef uint8_t byte;
typedef void (*unit_update)(void *, double, bool, bool, bool, bool, bool *, double *);
typedef void (*unit_log)(void *, int, const char *, const char *);
#endif
