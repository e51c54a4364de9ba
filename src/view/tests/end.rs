//! Closing the viewer, whatever it is doing.

use super::*;
use std::process::Command;
use std::sync::mpsc::channel;

/// Set in a process that runs one test only, so that all threads are of that test.
const ALONE: &str = "IRT_TEST_ALONE";

/// Names of the viewer's threads that there are.
fn threads() -> Vec<String> {
    let Ok(tasks) = std::fs::read_dir("/proc/self/task") else { return vec![] };
    let name = |task: std::io::Result<std::fs::DirEntry>| {
        std::fs::read_to_string(task.ok()?.path().join("comm")).ok()
    };
    let ours = |name: &String| name.starts_with("worker") || name.starts_with("renderer");
    tasks.filter_map(name).filter(ours).collect()
}

/// Closes the viewer after a while; the pictures that there were, and the most threads.
fn closed_after(scene: &Scene, wait: Duration) -> (usize, usize) {
    let options = RenderOptions { size: [900, 600], threads: Some(3), ..OPTIONS };
    let (link, (tell, news)) = (Link::default(), channel());
    let tell = move |piece: News| {
        let _ = tell.send(matches!(piece, News::Picture(_)));
    };
    let most = beside(scene, &options, Duration::from_millis(33), &link, tell, || {
        link.send(Event::Set(Setting::AntiAliasing(true)));
        link.send(Event::Press("d".into()));
        std::thread::sleep(wait);
        // What is left is traced at rest, in passes that may be stopped.
        link.send(Event::ReleaseAll);
        std::thread::sleep(wait);
        Ok(threads().len())
    });
    (news.iter().filter(|&picture| picture).count(), most.unwrap())
}

#[test]
fn closing_in_the_middle_of_a_frame_ends_all_threads() {
    if std::env::var_os(ALONE).is_none() {
        let name = "view::tests::end::closing_in_the_middle_of_a_frame_ends_all_threads";
        let exe = std::env::current_exe().unwrap();
        let output = Command::new(exe).args([name, "--exact"]).env(ALONE, "1").output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success() && text.contains("1 passed"), "{text}");
        return;
    }
    // Threads that build trees stay for the next one. They have the name of who was the first to build one.
    hash(&scene(), &OPTIONS);
    let (done, closed) = channel();
    std::thread::spawn(move || {
        let scene = scene();
        // From before the first picture to the passes at rest.
        for i in 0..16 {
            let _ = done.send(closed_after(&scene, Duration::from_millis(i * i)));
        }
    });
    let (mut pictures, mut most) = (vec![], 0);
    for _ in 0..16 {
        // Long enough for any machine, and short enough to tell of a viewer that hangs.
        let (made, had) = closed.recv_timeout(Duration::from_secs(120)).expect("the viewer ends");
        most = had.max(most);
        pictures.push(made);
    }
    assert!(pictures[0] < pictures[15], "{pictures:?}");
    if cfg!(target_os = "linux") {
        // Those of the viewer before may not be gone yet.
        assert!(most >= 4, "{most}, but a renderer and three workers");
    }
    // A thread is gone a moment after it was waited for.
    for _ in 0..1000 {
        if threads().is_empty() {
            return;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{:?} are left", threads());
}
