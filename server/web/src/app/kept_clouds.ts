// SPDX-License-Identifier: GPL-3.0-or-later
// The latest clouds, kept by this browser under the id that the server gave them, so that the link of a job shows its
// points again. Where the browser does not permit it, nothing is kept, and nothing else changes.
const kDatabase = 'surfaced';
const kStore = 'clouds';
const kMost = 6;
const kLargest = 64 << 20;

interface Kept {
  id: string;
  file: File;
  when: number;
}

function done<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error ?? new Error('the browser keeps no data'));
  });
}

async function open(): Promise<IDBDatabase> {
  const request = indexedDB.open(kDatabase, 1);
  request.onupgradeneeded = () => request.result.createObjectStore(kStore, {keyPath: 'id'});
  return done(request);
}

export async function keepCloud(id: string, file: File): Promise<void> {
  if (file.size > kLargest) return;
  try {
    const store = (await open()).transaction(kStore, 'readwrite').objectStore(kStore);
    await done(store.put({id, file, when: Date.now()} satisfies Kept));
    const all = (await done(store.getAll())) as Kept[];
    const old = all.sort((a, b) => b.when - a.when).slice(kMost);
    await Promise.all(old.map((each) => done(store.delete(each.id))));
  } catch (failure) {
    console.info('the cloud is not kept on this device:', failure);
  }
}

export async function keptCloud(id: string): Promise<File|undefined> {
  try {
    const store = (await open()).transaction(kStore).objectStore(kStore);
    return ((await done(store.get(id))) as Kept | undefined)?.file;
  } catch {
    return undefined;
  }
}
