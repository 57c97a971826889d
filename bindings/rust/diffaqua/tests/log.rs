// SPDX-License-Identifier: MIT
//! The log, alone in its process, since it is one for all threads.
mod scene;

use std::sync::{
    Arc, Mutex,
    atomic::{AtomicBool, Ordering},
};

use diffaqua::*;
use scene::*;

#[test]
fn messages_come_to_the_handler() {
    let seen = Arc::new(Mutex::new(Vec::new()));
    let (kept, wild) = (Arc::clone(&seen), Arc::new(AtomicBool::new(false)));
    let raises = Arc::clone(&wild);
    let handler = move |level: LogLevel, message: &str| {
        kept.lock().unwrap().push((level, message.to_owned()));
        if raises.load(Ordering::SeqCst) {
            panic!("a handler of the test raises this");
        }
    };
    set_log_handler(LogLevel::Debug, handler).unwrap();
    let mut simulator = swimmer(&settings());
    simulator.step(&[0.5], None).unwrap();
    let levels: Vec<LogLevel> = seen.lock().unwrap().iter().map(|entry| entry.0).collect();
    assert!(levels.contains(&LogLevel::Info) && levels.contains(&LogLevel::Debug), "{levels:?}");
    assert!(seen.lock().unwrap().iter().all(|entry| !entry.1.is_empty()));
    wild.store(true, Ordering::SeqCst);
    simulator.step(&[0.5], None).unwrap(); // a message stops nothing
    remove_log_handler().unwrap();
    assert_eq!(Arc::strong_count(&seen), 1);
    simulator.step(&[0.5], None).unwrap();
}
